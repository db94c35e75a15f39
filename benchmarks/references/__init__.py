"""Independent routes to the same numbers, as references for times and errors."""
