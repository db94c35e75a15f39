"""Numeric tolerances of the package: what each one bounds, its unit, and the reason.

Equality thresholds, limits of residuals and relative cut-offs stand here. Limits of counts,
sizes and times stand where they are used. Chain units are radians and characteristic lengths;
see `kinematics.model.arrays.Frame`.

Kernels (`kinematics.compiled.jit`) read some tolerances as compile-time constants: a change of
this file compiles all kernels anew.
"""

from __future__ import annotations

from fractions import Fraction

__all__ = [
    "ANGLE_ROUND_OFF",
    "AXES_PERPENDICULAR_COSINE",
    "CLOSURE_CONDITION",
    "COORDINATE_AXIS_DIFFERENCE",
    "EXACT_ANGLE_ERROR",
    "EXACT_SCREW_DIFFERENCE",
    "IDENTITY_POSE_ENTRY",
    "INERTIA_ASYMMETRY",
    "INERTIA_INEQUALITY_EXCESS",
    "LOOP_FRAME_DISTANCE",
    "LOOP_FRAME_ROUND_OFF",
    "PINOCCHIO_AXES_COSINE",
    "RIGHT_ANGLE_ENTRY",
    "ROTATION_ORTHOGONALITY",
    "ROTATION_PITCH",
    "ROUNDED_ANGLE_DIGITS",
    "ROUNDED_ANGLE_ERROR",
    "SINGLE_PRECISION_ANGLE",
    "UNIT_AXIS_SQUARED_LENGTH",
    "UNIVERSAL_AXES_PARALLEL_SINE",
]

# --- urdf: numbers and angles of a file

# Cosine of the angle between the axes of a universal joint that are perpendicular: files of
# six digits leave as much.
AXES_PERPENDICULAR_COSINE = 1e-6
# Excess of a principal moment over its bound, relative to the largest moment: files of six
# digits may break an inequality by as much.
INERTIA_INEQUALITY_EXCESS = 1e-5
# Entries of RᵀR - 1 of a pose that a loaded model gives: files have six digits or more.
ROTATION_ORTHOGONALITY = 1e-5
# Distance of a rounded angle from the multiple of π/12 that it stands for, rad.
ROUNDED_ANGLE_ERROR = 1e-4
# The same distance, in units of its last digit: one if the angle was rounded, two if π was
# rounded before half of it was taken (1.570795).
ROUNDED_ANGLE_DIGITS = 2.0
# The same distance of an angle in single precision, rad.
SINGLE_PRECISION_ANGLE = 1e-6
# Distance of two angles that are one, rad: many programs write twelve digits.
ANGLE_ROUND_OFF = 1e-11
# Distance of an angle from the multiple of π/12 that replaces it in exact arithmetic, rad.
EXACT_ANGLE_ERROR = Fraction(1, 10**12)
# Difference of joint screws from those of the reference pose, relative to the largest entry:
# exact arithmetic refuses screws of another pose.
EXACT_SCREW_DIFFERENCE = 1e-12
# Difference of the squared length of an axis from 1: within it, a unit vector was rounded.
UNIT_AXIS_SQUARED_LENGTH = Fraction(1, 10**4)
# Entries of the difference of an axis from a coordinate axis: a turn about it adds to one of
# roll, pitch and yaw.
COORDINATE_AXIS_DIFFERENCE = 1e-15

# --- urdf: frames of loops

# Distance of the two frames of a loop that coincide: angles in rad, and lengths in parts of
# the size of the loop. The rest is round-off of the products of rotations.
LOOP_FRAME_DISTANCE = 1e-12
# The same in parts of the extent of the linkage: the round-off of coordinates.
LOOP_FRAME_ROUND_OFF = 1e-14
# Sine of the angle between the axes of a universal loop that are parallel.
UNIVERSAL_AXES_PARALLEL_SINE = 1e-12

# --- building

# Distance of a sine or cosine from 0 or 1: within it, the angle is a multiple of π/2.
RIGHT_ANGLE_ENTRY = 1e-15
# Asymmetry of an inertia tensor, relative to its largest entry: the round-off of a product.
INERTIA_ASYMMETRY = 1e-12
# Entries of the difference of a pose from the identity, in 1 and metres.
IDENTITY_POSE_ENTRY = 1e-12
# Cosine of the angle between the axes of a universal joint of Pinocchio that are
# perpendicular: they are unit vectors in double precision.
PINOCCHIO_AXES_COSINE = 1e-12
# Pitch of a screw that is a rotation, relative to the length of its linear part.
ROTATION_PITCH = 1e-13

# --- taylor

# Condition number of the closure equations beyond which they determine no motion.
CLOSURE_CONDITION = 1e9
