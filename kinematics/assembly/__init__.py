"""From a draft to a linkage: closed loops, axes, coordinates, reference pose."""
