"""Run processes, and print lines and tables."""
