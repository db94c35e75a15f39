"""Build linkages without a file.

``screw_joints``, ``dh_rows`` and ``pinocchio_model`` make the elements of a URDF file from
joint screws, Denavit-Hartenberg parameters and a Pinocchio model; ``numbers`` checks their
numbers; ``assembled`` checks, reads and assembles the elements like those of a file.
"""
