"""Tolerances of `balance`, each named for what it bounds, with its unit and its reason."""

from __future__ import annotations

__all__ = [
    "AGREEMENT_RELATIVE",
    "BALL_DISTANCE_EQUAL",
    "BOUND_RELATIVE",
    "CERTIFICATE_ENTRY_RELATIVE",
    "CERTIFICATE_MARGIN",
    "CERTIFICATE_RANK_RELATIVE",
    "CERTIFICATE_RESIDUAL",
    "CERTIFICATE_RIDGE_RELATIVE",
    "COMPONENT_ZERO_RELATIVE",
    "CONDITIONING_LEAST",
    "CONDITIONING_NOTICE",
    "CONDITIONING_SINGULAR",
    "CRANK_ADVANCE",
    "DESIGN_RESIDUAL",
    "FAR_ORIGIN_ROUND_OFF",
    "FIXED_RANK_RELATIVE",
    "FORCE_EQUAL_RELATIVE",
    "INPUT_RANGE_RELATIVE",
    "JOINT_RATE_RATIO",
    "KEPT_BODY_RESIDUAL",
    "LINE_END_RELATIVE",
    "LINK_LENGTH_ZERO",
    "MASS_MULTIPLIER_RELATIVE",
    "MOTION_RETURN",
    "POINT_EQUAL_RELATIVE",
    "PSEUDO_INERTIA_SINGULAR",
    "RATE_RESIDUAL_RELATIVE",
    "RELATION_RESIDUAL",
    "REVOLUTION_RETURN",
    "SECOND_MOMENT_NEGATIVE_RELATIVE",
    "SHAKING_RELATIVE",
    "SOLVER_INFEASIBILITY",
    "SOLVER_RESIDUAL",
    "SOLVER_RESIDUAL_FAST",
]

# --- designs

# Largest margin of a design that a certificate may leave possible, relative to the total trace
# of the pseudo-inertias: well above the round-off of the check, far below any real body.
CERTIFICATE_MARGIN = 1e-12
# Eigenvalues of the solver's certificate that count as zero, relative to the largest one. The
# solver is accurate to about 1e-8, so the rank is tried with several values, likely ones first.
CERTIFICATE_RANK_RELATIVE = (1e-6, 1e-5, 1e-4, 1e-3, 1e-7)
# Residual at which Gauss-Newton stops on a certificate, for factors of unit size: round-off.
CERTIFICATE_RESIDUAL = 5e-15
# Diagonal term of its normal equations, relative to their mean diagonal: round-off, so that
# dependent conditions do not make them singular.
CERTIFICATE_RIDGE_RELATIVE = 1e-15
# Entries of a certificate that count as zero where the multiplier of a mass bound is taken from
# it, relative to its largest entry: round-off of a factorised matrix.
MASS_MULTIPLIER_RELATIVE = 1e-13
# Entries of a certificate that count as zero where its bodies are named, relative to the
# largest entry: round-off of a refined certificate.
CERTIFICATE_ENTRY_RELATIVE = 1e-12
# Residual at which the conic solver declares a problem infeasible; the certificate is refined
# afterwards.
SOLVER_INFEASIBILITY = 1e-10
# Residuals and relative gap at which the conic solver stops: careful, and fast.
SOLVER_RESIDUAL = 1e-10
SOLVER_RESIDUAL_FAST = 1e-9
# Singular values of the conditions of kept bodies and fixed masses that count as zero, relative
# to the largest one: file values carry ten digits or more.
FIXED_RANK_RELATIVE = 1e-10
# Distance of a design from the design space over its own size, and smallest margin: round-off
# of a solution that is projected onto the space.
DESIGN_RESIDUAL = 1e-12
# Round-off of parameters about a far inertial origin, per square of its distance in
# characteristic lengths.
FAR_ORIGIN_ROUND_OFF = 1e-15
# The same distance with kept bodies: masses in files are rounded to about nine digits.
KEPT_BODY_RESIDUAL = 1e-9
# Violation of mass bounds and ball radii, relative to them: the accuracy of the conic solver.
BOUND_RELATIVE = 1e-8
# Length of a link that counts as zero, in characteristic lengths of the linkage.
LINK_LENGTH_ZERO = 1e-3
# Distances that count as equal where a smallest ball is sought, in characteristic lengths:
# round-off.
BALL_DISTANCE_EQUAL = 1e-12
# Smallest eigenvalue of a pseudo-inertia that counts as zero, relative to its trace: below it
# the inverse has no correct digit.
PSEUDO_INERTIA_SINGULAR = 1e-12

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
# Advance of a crank per continuation step at which it has reached its limit, radians.
CRANK_ADVANCE = 1e-7
# Range of the inputs of a motion that counts as rest, relative to their size.
INPUT_RANGE_RELATIVE = 1e-12
# Residual of the relations of a motion, relative to displacements above 1 rad or 1 m: decimals
# of a table.
RELATION_RESIDUAL = 1e-9
# Loop residual of given joint rates, relative to their size: decimals of a table.
RATE_RESIDUAL_RELATIVE = 1e-6

# --- taylor_poses

# Part of a line by which a pose may miss or pass its end.
LINE_END_RELATIVE = 1e-9

# --- report

# Distance at which points of a drawing coincide, relative to the size of the linkage.
POINT_EQUAL_RELATIVE = 1e-6
# Difference at which joint forces are drawn as one line, relative to the largest force.
FORCE_EQUAL_RELATIVE = 1e-6
# Components of a printed vector that count as zero, relative to the largest one.
COMPONENT_ZERO_RELATIVE = 1e-9
# Negative second moment about the centre of mass that counts as zero, relative to the largest.
SECOND_MOMENT_NEGATIVE_RELATIVE = 1e-9
