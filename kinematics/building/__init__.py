"""Linkages without a file, and the file of a linkage.

``screw_joints``, ``dh_rows`` and ``pinocchio_model`` make the elements of a URDF file from
joint screws, Denavit-Hartenberg rows and a model of Pinocchio; ``elements`` makes single
elements; ``assembled`` has them checked, read and assembled like those of a file;
``urdf_text`` writes the file of any linkage.
"""

__all__: list[str] = []
