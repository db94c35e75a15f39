"""Numeric tolerances of motions, poses and paths, each named for what it bounds.

Those of mass distributions are in `balance.support.tolerances`. Where no unit is given, a
tolerance is relative to the size that its comment names.
"""

from __future__ import annotations

# --- verification

# Peak shaking force and moment of a balanced linkage, relative to the peak inertia forces:
# round-off along a motion, and masses rounded to nine digits.
SHAKING_RELATIVE = 1e-9
# Difference between Pinocchio and the momentum series, relative to the peak inertia forces.
AGREEMENT_RELATIVE = 1e-9
# Conditioning of the loops relative to the reference pose below which a notice says that
# round-off is amplified.
CONDITIONING_NOTICE = 0.02
# The same below which the joint rates of a crank are not determined: branches meet there.
CONDITIONING_SINGULAR = 1e-6
# The same below which a random motion counts as near-singular, and the joint rates, over those
# at the reference pose, above which it does.
CONDITIONING_LEAST = 0.25
JOINT_RATE_RATIO = 4.0
# Displacement of the joints at the end of a random motion from the start, radians and
# characteristic lengths: above Newton's residual, far below the distance of two branches.
MOTION_RETURN = 1e-9
# The same after one revolution of a crank, up to full turns.
REVOLUTION_RETURN = 1e-8
# Difference of the positions of joints along a path of a tool and along that of the inputs, in
# radians and characteristic lengths: above round-off near singular poses, far below the
# distance of two branches.
SAME_BRANCH = 1e-6
# Advance of a crank per continuation step at which it has reached its limit, radians.
CRANK_ADVANCE = 1e-7
# Range of the inputs of a motion that counts as rest, relative to their size.
INPUT_RANGE_RELATIVE = 1e-12
# Way of the inputs from one sample to the next up to which they rest, radians and
# characteristic lengths: the round-off of Newton's method is no small part of a shorter one.
SAMPLE_REST = 1e-13
# Residual of the relations of a motion, relative to displacements above 1 rad or 1 m: decimals
# of a table.
RELATION_RESIDUAL = 1e-9
# Loop residual of given joint rates, relative to their size: decimals of a table.
RATE_RESIDUAL_RELATIVE = 1e-6
# Joint wrench per unit of preload, in characteristic lengths, up to which there is none.
PRELOAD_ROUND_OFF = 1e-9
# Error of accelerations from a rounded table, relative to their peak, above which it is told.
ROUNDING_NOTICE = 1e-6
# Step of the inputs of central differences of loads, radians and characteristic lengths: their
# error is its square.
DISPLACEMENT_STEP = 1e-5

# --- manufacture

# Displacement of an axis for central differences of loads, characteristic lengths: their error
# is its square.
AXIS_SHIFT = 1e-5
# Closure residual with an axis that is displaced so far, radians and characteristic lengths.
AXIS_SHIFT_CLOSED = 1e-10

# --- instantaneous

# Singular value of the momentum matrix over the momenta of the bodies: up to this the rates
# leave the base at rest. The same for parts of a momentum that must vanish.
MOMENTUM_NULL = 1e-9
# Difference of principal moments, or sine of an angle between momentum and angular velocity:
# below this they are equal, or parallel.
MOMENTS_EQUAL = 1e-9

# --- reactionless_paths

# Quadratic form of a tangent cone over the momenta of the bodies: up to this it vanishes.
CONE_RESIDUAL = 1e-7
# Discriminant of a form of size 1 up to which two lines of a cone are one, and sine of the
# angle up to which they are.
CONE_DOUBLE_ROOT = 1e-6
# Momentum over those of the bodies, divided by the advance, that a branch near a meeting of
# paths may leave; and the change of its coefficients at which it is found.
LOCAL_CURVE_RESIDUAL = 1e-11
LOCAL_CURVE_STEP = 1e-9
# Distance from a branch through a meeting up to which a path is on it, radians and
# characteristic lengths.
ON_LOCAL_CURVE = 1e-8
# Relative and absolute error of one step of the integration, radians and characteristic
# lengths.
PATH_STEP_ERROR = 1e-13
# Momentum along a path over those of the bodies: above this it is none.
PATH_MOMENTUM = 1e-8
# Conditioning of the loops relative to the reference pose at which a path ends as singular.
PATH_CONDITIONING = 2e-3
# Joint rate over that of the inputs, radians and characteristic lengths, above which the loops
# cannot be closed beyond a singular pose: it is the edge of the workspace.
PATH_EDGE_RATE = 50.0

# Momentum at Gauss points of a path between given poses, over what its rates could make, up to
# which there is none: round-off.
PATH_CONNECTED = 2e-11
# Distance of a path from a pose, radians and characteristic lengths, up to which it leads
# through it.
PATH_REACHED = 1e-7

# --- taylor_poses

# Part of a line by which a pose may miss or pass its end.
LINE_END_RELATIVE = 1e-9

# --- floating_base

# Relative tolerance of the steps of an integration; the least that DOP853 takes is 2.2e-14.
BASE_STEP_RELATIVE = 2e-12
# Speed of a base that counts as at rest, relative to the speed of the bodies on it: masses in
# files are rounded to nine digits.
BASE_AT_REST_RELATIVE = 1e-9
# Rates of the inputs at the start, over their largest, up to which a motion starts at rest: a
# spline through samples of one that does leaves some.
STARTS_AT_REST = 1e-2
# Drift of energy or momentum, relative to their peaks, up to which a simulation is trusted.
BASE_DRIFT_RELATIVE = 1e-9
# Smallest eigenvalue of a mass matrix with unit diagonal that counts as zero.
MASS_MATRIX_SINGULAR = 1e-12
# Square of a natural frequency that counts as zero, relative to the largest one.
FREQUENCY_ZERO = 1e-12

# Sizes along an integrated motion, relative to what they are compared with, up to which the
# steps of the integration and round-off decide them: they are written as bounds.
INTEGRAL_DETERMINED = 1e-9

# Loads of a motion that passes near a singularity, relative to the inertia of the bodies, up to
# which round-off decides them.
SINGULAR_MOTION_DETERMINED = 1e-6

# --- flexible

# Difference of the peaks of a mode, relative to them, up to which the first gives its sign.
MODE_PEAKS_EQUAL = 1e-6
# Deflection of the supports in a rigid motion of unit size, up to which they do not hold it.
RIGID_MOTION_HELD = 1e-9

# --- quiet

# Closure residual at samples of a plan, radians and metres: round-off, so that central
# differences of loads keep their digits.
SAMPLED_LOOPS_CLOSED = 1e-12
# Excess over a limit, relative to it, up to which a planned motion keeps it: what happens
# between samples.
QUIET_LIMIT_EXCEEDED = 2e-3
# Excitation of the base at one of its natural frequencies, over the shaking of the first
# motion, up to which there is none: the discretisation.
QUIET_EXCITED = 5e-3
# Distance from a pose that a plan passes, over the size of the motion, up to which it does:
# round-off of Newton's method.
QUIET_POSE_MISSED = 1e-8
# Gain of a step of a plan, relative to the shaking, below which it is at a minimum.
QUIET_STEP_GAIN = 1e-4
# Speed, acceleration or torque of an input over that of the input with most of it, up to which
# the input of a plan has none: the accuracy of the conic solver.
QUIET_INPUT_RESTS = 1e-6
# Excess of the shaking over its bound up to which a motion is optimal: the discretisation.
BOUND_REACHED = 0.01

# --- synthesis

# Lengths relative to the size of the positions, and 1 - e^(iφ) or a sine, that count as zero.
SYNTHESIS_SINGULAR = 1e-9
# Angle between the links, radians, at which a parallelogram counts as flat: three degrees.
SYNTHESIS_LINK_FLAT = 0.05
# Angle error of a design on a zero contour, radians.
SYNTHESIS_ANGLE_MET = 1e-10
# Distance from a position, relative to their size, up to which it is met.
SYNTHESIS_MET = 1e-9
# Momentum of a synthesised mechanism, relative to the sum of that of its bodies.
SYNTHESIS_MOMENTUM = 1e-10
# Its shaking, relative to the inertia of the bodies. Its motions may pass flat parallelograms,
# where round-off is amplified.
SYNTHESIS_SHAKING = 1e-8

# --- sweeps

# Distance of a closed pose from Newton's first step, over the length of that step: up to this
# the geometry is on the branch of the one before.
SWEEP_BRANCH_DISTANCE = 0.3
# Closure residual of closed loops, in radians and characteristic lengths.
SWEEP_CLOSED = 1e-11
# Largest entry of a Newton step after which the next one is round-off.
SWEEP_NEWTON_DONE = 1e-8
# Damping of the normal equations over the mean of their diagonal: of dependent joints, which
# the loops determine, and of all joints, some of which are free.
SWEEP_DAMPING = 1e-14
SWEEP_FREE_DAMPING = 1e-9
