"""Motions and loads of a linkage as it is, and whether it shakes its base."""
