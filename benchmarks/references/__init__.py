"""Other routes to the same numbers, to compare times and errors with."""
