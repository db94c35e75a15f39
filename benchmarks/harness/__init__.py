"""How benchmarks run and print: processes, lines, the table."""
