"""Numbers: linear algebra, compiled kernels, tolerances."""
