"""Read URDF files, and the YAML files beside them, to unassembled linkages.

``xml_tree`` and ``yaml_keys`` parse XML and YAML; ``validate`` and the files named after it
reject invalid files; ``loop_file`` merges the YAML file into the tree; ``rounded_angles``
replaces rounded angles; ``robot_tree`` reads joints, poses and inertias, and
``yourdfpy_adapter`` converts a model that yourdfpy has loaded; ``loop_joints`` and ``read``
build joints, bodies and welds. ``rational_screws`` computes the joint screws in rational
numbers; ``write_closed_pose`` writes the file at another pose.
"""
