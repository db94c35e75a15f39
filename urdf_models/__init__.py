"""A gallery of linkages as URDF files; see the README beside this file."""
