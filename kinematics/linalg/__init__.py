"""Linear algebra: one algorithm a file."""
