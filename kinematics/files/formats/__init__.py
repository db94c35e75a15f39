"""Files of robots: URDF and its dialects, and other formats converted to URDF.

Every reader converts its file to the elements of a URDF file with loops. The checks, the
numbers and the loops are then those of `kinematics.files.urdf`, whatever the format.
"""
