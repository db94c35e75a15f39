"""Numeric tolerances of the package: what each one bounds, its unit, and the reason.

Equality thresholds, limits of residuals and relative cut-offs stand here. Limits of counts,
sizes and times stand where they are used. Chain units are radians and characteristic lengths;
see `kinematics.model.arrays.Frame`.

Kernels (`kinematics.numerics.compiled.jit`) read some tolerances as compile-time constants: a
change of this file compiles all kernels anew.
"""

from __future__ import annotations

from fractions import Fraction

# --- wording
# Components of a vector below this part of the largest are written as 0; dimensionless.
WRITTEN_AS_ZERO = 1e-10
# Sizes relative to their scale up to which round-off decides them: they are written as bounds.
# Sums over some hundred terms of double precision stay three decades below.
SIZE_DETERMINED = 1e-12
# The same for differences of two poses that Newton's method closes.
POSE_DETERMINED = 1e-10
# The same for the smallest singular value of a regressor and what is derived from it: its
# absolute error is that of the largest one, and two digits of it are written.
MARGIN_DETERMINED = 1e-8
# Significant digits of a computed number that round-off leaves.
NUMBER_DETERMINED = 10

# --- linalg
# Pivots and singular values of a regressor that are zero, relative to the largest one.
# Measured round-off lies below 1e-14 for well-conditioned loops; this leaves two decades to
# those that are not.
RANK_RELATIVE = 2.0**-40
# Factor above `RANK_RELATIVE` within which a pivot that is kept counts as uncertain.
RANK_MARGIN = 1e3
# What `RANK_RELATIVE` grows to in a frame far from the origin of its file, per characteristic
# length of the distance: coordinates are rounded relative to it.
RANK_RELATIVE_PER_LENGTH = 2.0**-44
# Round-off of the rows of a factor, relative to its largest pivot; their multipliers amplify
# it when other rows are eliminated.
ELIMINATION_ROUND_OFF = 2.0**-46
# Entries of orthonormal vectors that are round-off, and set to 0; dimensionless.
ORTHONORMAL_ROUND_OFF = 2.0**-48
# Relative round-off of a decimal that was printed from double precision: 15 digits.
DECIMAL_ROUND_OFF = Fraction(1, 10**15)

# Difference of numbers, relative to the largest, up to which they are equal where one of them
# is chosen: the first one is.
TIE_RELATIVE = 1e-9

# --- spatial
# Part of a screw along or across its line that counts as zero, relative to its moment: a few
# hundred roundings of double precision.
SCREW_PART_RELATIVE = 1e-13

# --- urdf_elements
# Axes of one joint of a file meet, are parallel or at right angles if they deviate by less,
# in parts of the size of the linkage or of 1: what the digits of the file leave.
JOINT_AXES_MEET = 1e-12
# Entries of a rotation matrix that are round-off, dimensionless.
ROTATION_ROUND_OFF = 1e-15

# --- model

# Part of a turn by which half a turn backwards is half a turn forwards: closed poses are known
# to about 1e-12.
HALF_TURN_ROUND_OFF = 1e-9
# Deviation of screws from a planar motion: sine of the angle between axes, and pitches and
# slides along the normal in chain units.
PLANAR_DEVIATION = 1e-9
# Distance of axes from the middle of a linkage that is zero, as axes that meet have, in parts
# of its largest coordinate: round-off of the file.
MEETING_AXES_COORDINATE = 1e-9
# The same in parts of the size of the linkage: four decimals, as axes of a file may have.
MEETING_AXES_SIZE = 1e-4
# Change of an axis that counts as rounding, in radians, or in parts of the size of the
# linkage: four decimals.
AXIS_ROUNDING = 1e-4
# Part of the largest coefficient of a motion relation that rounding of its decimals may leave
# where it repeats others: twelve digits.
RELATION_ROUND_OFF = Fraction(1, 10**12)

# --- closure
# Closure residual (chain units) below which Newton's method takes no step: round-off.
NEWTON_ROUND_OFF = 1e-15
# Closure residual (chain units) below which a step that does not halve it ends Newton's method.
NEWTON_STALL_RESIDUAL = 1e-12
# Closure residual (chain units) above which Newton's method has diverged.
NEWTON_DIVERGED = 1e6
# Closure residual (chain units) of a pose that continuation accepts: two decades above the
# residual at which Newton's method may stop.
FOLLOWED_POSE_RESIDUAL = 1e-10
# Squared distance of a pose from the prediction, relative to the square of the step: a pose
# that is further away is on another branch.
BRANCH_DISTANCE_SQUARED = 0.01
# Closure residual (chain units) that counts as closed where a caller gives the positions of
# all joints: eight digits.
GIVEN_POSE_RESIDUAL = 1e-8

# --- mobility
# Singular values of a loop matrix that are zero, relative to the largest: geometry in files is
# given to about 1e-12.
LOOP_RANK_RELATIVE = 1e-8
# The same at poses that were solved for, which have errors of their own.
LOOP_RANK_RELATIVE_SOLVED = 1e-7
# Closure residual (chain units) of loops that were closed to round-off.
CLOSED_TO_ROUND_OFF = 1e-13
# Closure residual at an order of a power series that is round-off, relative to the joint
# rates of that order (chain units).
SERIES_RESIDUAL = 1e-9
# Closure residual (chain units) of a pose near a singular one that is closed: two decades above
# the residual at which the search for it ends.
NEAR_SINGULAR_RESIDUAL = 1e-12
# Step, and residual, at which the search for closed poses near a singular one ends (relative to
# their distance): round-off.
NEAR_SINGULAR_STEP = 1e-12
NEAR_SINGULAR_CONVERGED = 1e-14
# Distance of two poses that are the same, relative to their distance from the singular one.
SAME_POSE_RELATIVE = 1e-3
# Size of a component of loops over its distance from the ground that leaves enough digits in
# double precision; below the second ratio its joints coincide but for round-off.
COMPONENT_SIZE_RELATIVE = 4e-9
COINCIDENT_JOINTS_RELATIVE = 1e-14
# Distance of the ends of two chains that are at one place, relative to the size of the machine:
# four decimals of a file.
ENDS_MEET = 1e-4
# Rate of a joint that stands still, relative to the fastest joint: a dead centre written with
# six decimals leaves about 1e-6.
STANDSTILL_RELATIVE = 1e-5
# Freedom of a joint or of a tool that is left once others are chosen, relative to its rate:
# half the digits of double precision.
REMAINING_FREEDOM = 1e-8

# --- assembly
# Closure residual (chain units, entries of a displacement) that counts as closed.
CLOSURE_RESIDUAL = 1e-11
# Gap of loops (radians and lengths in parts of the size) that may be meant to close, but for
# rounded axes.
ALMOST_CLOSED_RESIDUAL = 1e-2
# Sum of squares of that residual at which steps that close loops end; Newton steps follow.
CLOSED_SQUARE = 1e-14
# Motion that closes loops, in parts of the size of the linkage, for which no nearer pose is
# looked for.
NEAR_MOTION = 0.1
# Motion from one closed pose to another, relative to the one that closed the loops, by which
# the two differ; and how much more motion than that counts as nearby.
OTHER_MOTION_RELATIVE = 0.5
NEARBY_MOTION_RELATIVE = 2.0
# Difference of two motions that close loops, relative to them, up to which they are as far:
# the search for the nearest pose ends at about 1e-6.
MOTION_EQUAL = 1e-5
# Motion of joints (chain units) in closing loops that is not worth a notice: round-off.
UNMOVED_DISTANCE = 1e-9
# Motion of a joint (chain units) by which a pose is another than the reference pose.
OTHER_POSE_DISTANCE = 0.2
# Position of a joint (SI units) that messages leave out as 0.
NAMED_POSITION = 1e-3
# Singular values left out by steps that close loops, relative to the largest: those to a
# solution, and those to a pose that rounded axes nearly close.
CLOSING_STEP_RELATIVE = 1e-9
NEARLY_CLOSING_STEP_RELATIVE = 1e-3
# Displacement of a joint up to a generic pose that is none, relative to the largest one: an
# idle joint.
IDLE_JOINT_RELATIVE = 1e-9
# Rate of a joint at the reference pose that is clearly no round-off, relative to the largest.
CLEAR_MOTION_RELATIVE = 1e-3
# Smallest nonzero singular value of a loop matrix, relative to the largest: poses below the
# first may be near a singular one; those below the second cannot be told from it.
NEAR_SINGULAR_CONDITIONING = 0.05
SINGULAR_CONDITIONING = 1e-3
# The same below which the pose was meant to be singular, and distance (chain units) of a pose
# that shows it: next to a singular pose, joint positions are known to the root of round-off.
INDISTINGUISHABLE_CONDITIONING = 1e-6
BEYOND_SINGULAR = 1e-3
# Smallest relative singular value of a loop matrix that twelve digits of a file resolve.
LOOP_RANK_OF_FILE = 1e-11
# Closure residual (chain units) with fitted axes, at poses that were not used for the fit.
FIT_RESIDUAL = 1e-12
# Step (chain units) at which the fit of axes ends: round-off.
FIT_CONVERGED = 1e-15
# Largest change of an axis that a fit tries, in radians or parts of the size of the linkage,
# to find out how far it is from closing the loops.
MAX_TRIED_AXIS_CHANGE = 1e-2
# Smallest and largest cut-off of a step of the fit, relative to the largest singular value; in
# between it is a hundred times the residual.
FIT_STEP_RELATIVE_MIN = 1e-9
FIT_STEP_RELATIVE_MAX = 1e-5

# --- meant

# Difference of the screws of the meant geometry from those of the reference pose, relative to
# the largest entry, up to which no axis is moved: round-off.
MEANT_DIFFERENCE = 1e-14

# --- urdf: numbers and angles of a file

# Cosine of the angle between the axes of a universal joint that are perpendicular: files of
# six digits leave as much.
AXES_PERPENDICULAR_COSINE = 1e-6
# Excess of a principal moment over its bound, relative to the largest moment: files of six
# digits may break an inequality by as much.
INERTIA_INEQUALITY_EXCESS = 1e-5
# Entries of RᵀR - 1 of a pose that a loaded model gives: files have six digits or more.
ROTATION_ORTHOGONALITY = 1e-5
# Distance of a rounded angle from the multiple of π/12 that it stands for, relative to it:
# three decimals of π/12 cut off.
ROUNDED_ANGLE_RELATIVE = 4e-3
# Distance of two angles that are one, rad: many programs write twelve digits.
ANGLE_ROUND_OFF = 1e-11
# Distance of an angle from the multiple of π/12 that replaces it in exact arithmetic, rad.
EXACT_ANGLE_ERROR = Fraction(1, 10**12)
# Coordinate of an origin, in parts of the largest of all, that is left of sums of others in
# double precision: a hundred units of its last digit.
ORIGIN_ROUND_OFF = 3e-14
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
# Distance of two loops that a file gives in the words of two tools: angles in rad, and lengths
# in parts of those of their frames. Tools write six digits or more.
REPEATED_LOOP = 1e-5

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
