"""Reading files: from what users have to a draft of a linkage.

``markup`` and ``keyfile`` parse XML and YAML and nothing more; ``fields`` and ``guard``
refuse what cannot be meant; ``sidecar`` merges the YAML beside a file into it; ``angles``
reads rounded angles as they are meant; ``frames`` reads joints, poses and inertias, and
``yourdf`` takes them from a model that yourdfpy has loaded; ``loops`` and ``urdf`` build
joints, bodies and welds.
"""

__all__: list[str] = []
