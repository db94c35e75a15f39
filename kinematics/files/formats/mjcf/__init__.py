"""MJCF files, compiled by the package ``mujoco``.

A file is expanded and reduced here, under the limits of every other file, to what concerns
the linkage. MuJoCo's compiler then resolves defaults, frames, angles and inertias of geoms.
The compiled bodies, joints and equality constraints become the elements of a URDF file.
"""
