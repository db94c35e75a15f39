"""Files that describe robots: URDF, SDF, MJCF, xacro, and their dialects of loops."""
