"""Reading files: from what users have to a draft of a linkage.

``xml_tree`` and ``yaml_keys`` parse XML and YAML and nothing more; ``validate`` and the files
named after it refuse what cannot be meant; ``loop_file`` merges the YAML beside a file into
it; ``rounded_angles`` reads rounded angles as they are meant; ``robot_tree`` reads joints,
poses and inertias, and ``yourdfpy_adapter`` takes them from a model that yourdfpy has loaded;
``loop_joints`` and ``read`` build joints, bodies and welds.
"""

__all__: list[str] = []
