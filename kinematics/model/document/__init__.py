"""Elements of a URDF file: their data, elements made from numbers, and a linkage as text."""
