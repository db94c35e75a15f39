"""Elements of a URDF file: as data, made from numbers, and those of a linkage as text."""
