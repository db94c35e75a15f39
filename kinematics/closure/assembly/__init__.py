"""Assembly of a linkage: closed loops, fitted axes, coordinates, reference pose."""
