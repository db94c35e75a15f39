"""Numeric tolerances of this package, each named for what it bounds.

Where no unit is given, a tolerance is relative to the size that its comment names. Kernels
(`kinematics.numerics.compiled.jit`) read some of them: they are constants at compile time, so
this file belongs to the sources whose hash names the folder of compiled kernels. Limits that
are no tolerances, such as numbers of steps or sizes of batches, stand where they are used.
"""

from __future__ import annotations

# --- inertial_parameters

# Mass, or first moment in characteristic lengths, over the size of the whole distribution:
# below this it is what rounding leaves of a sum that cancels.
MASS_ROUND_OFF = 1e-12
# Moment of inertia over the largest moment of the body: below this it is what the shift to the
# centre of mass, a difference of large numbers, leaves.
MOMENT_ROUND_OFF = 1e-9
# Part of the largest moment by which rounded numbers in files may violate an inequality of
# physical bodies.
PHYSICAL_INEQUALITY = 1e-9
# Smallest singular value of the dyads of six unit vectors: below this, rods along them do not
# make up every inertia.
ROD_DYADS_SINGULAR = 1e-10

# --- momentum

# Momentum of a body over the largest one: below this the body is at rest.
BODY_AT_REST = 1e-12
# Sine of the angle between lines: below this they are parallel, and do not meet.
LINES_PARALLEL_SINE = 1e-9
# Distance of lines from one point over the size of the picture: up to this they meet in it.
LINES_MEET = 1e-6

# --- formulas

# Coordinate of a point of a link over the size of the link: below this formulas leave it out.
FORMULA_ZERO = 1e-9
# Difference of two distances over their size: up to this they are equal in formulas.
FORMULA_RELATION = 1e-9
# Violation of formulas by balanced masses over the sizes of their terms: up to this they agree.
# Formulas of another motion are off by 1e-2 or more, round-off by up to 1e-11.
FORMULA_AGREES = 1e-9

# --- conditions

# Radius of convergence in radians: series that converge no further say little about poses, so
# finite poses are added.
SHORT_CONVERGENCE_RADIUS = 1e-2

# --- transfers

# Sine of the angle between a direction and known ones: below this it is one of them. Spaces
# that meet at a smaller angle, but one above round-off, need a linkage drawn to ten digits.
TRANSFER_DIRECTION_EQUAL = 2.0**-30
# A size that was dropped is round-off beyond doubt below this part of the limit of round-off;
# in regular linkages it is about 1e-15.
DROPPED_CLEARLY = 0.01
# A size that was kept, over the whole, counts beyond doubt above this; in regular linkages it
# is about 1e-2.
KEPT_CLEARLY = 1e-6
# Entry of a transfer of size 1, in the units of the chain: up to this it is round-off.
TRANSFER_ENTRY_ROUND_OFF = 1e-12

# --- spaces

# Residual of the masses in a file over the sum of the parts of the bodies: up to this they are
# balanced, since masses in files are rounded.
AS_GIVEN_RESIDUAL = 1e-9
# Size of the mass of a body in an orthonormal basis of a space: up to this it has none in any
# distribution of the space.
MASS_NEVER = 1e-9
# Smallest singular value kept, over the largest. A special geometry that is missed by δ has
# conditions of the size δ, δ² …: below this, the second may be round-off.
SQUARE_ROUND_OFF = 5e-8
# Sine of the largest angle between two spaces: up to this they are one space.
SPACES_EQUAL_SINE = 1e-6
# Distance of a geometry from one of lower rank, in characteristic lengths and radians: beyond
# this, a first-order estimate is meaningless.
FIRST_ORDER_CHANGE = 0.3
# Part of a change of geometry by which loops may open: beyond this, the change is not one of
# the linkage.
CHANGE_OPENS_LOOPS = 1e-3
# Change of geometry that lowers the rank, relative to the size: up to this, its first digits
# are not determined, for its absolute error is that of the largest singular value.
CHANGE_DETERMINED = 1e-7
# Distance over the characteristic length, or difference of unit axes: up to this, joints are at
# one point, and axes are one.
JOINTS_COINCIDE = 1e-9

# --- search

# Closure residual in the frame of a geometry: those that stay closed up to this are those
# of a linkage that moves.
SWEEP_CLOSURE_RESIDUAL = 1e-11
# Pivots of the loop matrix over the largest: below this a geometry is passed to
# `design_space`, which leaves singular poses.
SWEEP_REGULAR = 1e-2
# Rates of joints over the fastest: below this a joint may be idle, and a geometry is passed to
# `design_space`.
SWEEP_SLOWEST = 1e-5
# Smallest pivot of the conditions over the largest: below this the smallest singular value may
# leave a doubt, and is computed; a geometry whose conditions are not of full column rank is
# passed to `design_space`.
SWEEP_PIVOT_CLEAR = 1e-6
# Deviation of a unit axis from length 1, from the normal of a plane, or of a screw from having
# no pitch: up to this it is rounded.
SCREW_ROUNDED = 1e-9
# Characteristic length over the largest coordinate: below this it is round-off; as in
# `kinematics.model.chain.arrange_loops`.
LENGTH_ROUND_OFF = 1e-9
# Characteristic length over the largest distance from the origin: below this it is too small
# for a unit; as there.
LENGTH_SHORT = 1e-4

# --- interpretation

# Distances over the characteristic length, and sines of angles: up to this they are zero.
GEOMETRY_EQUAL = 1e-9
# Distance of a joint from an axis over the characteristic length: beyond this it gives a
# direction across the axis.
AXIS_OFFSET_CLEAR = 1e-3
# Singular value of terms of unit size: up to this it does not count for their rank.
TERMS_RANK = 1e-9
# Pivot of unit rows in echelon form, and entry over the largest of its row: up to this it is
# round-off.
ECHELON_PIVOT = 1e-11
# Difference of a value, relative to the largest, from a simple fraction: up to this it is
# round-off, and taken off.
FRACTION_ROUND_OFF = 1e-12
# The same for a value that is written as a fraction.
FRACTION_IN_TEXT = 1e-9
# Value of a term over the largest in the solution of a linear programme: up to this, the term
# is not in it.
TERM_ABSENT = 1e-6
# Part of a solution outside the space over its new part: up to this it lies in the space.
SOLUTION_OUTSIDE = 1e-11
# Sine of the angle between solutions, and new part of a unit column: up to this they are zero.
SOLUTIONS_EQUAL = 1e-6

# --- certification

# Momentum at a finite pose of a distribution of size 1, over the conditions there: up to this
# there is none.
MOMENTUM_RESIDUAL = 1e-11
# The same, for small loops on long arms, if exact arithmetic finds no condition at many further
# orders.
MOMENTUM_RESIDUAL_ILL_CONDITIONED = 1e-6
# Angle between axes in radians that double precision may have rounded away from 0.
PARALLEL_AXES_ROUNDED = 1e-15
# Relative pivot that counts as round-off where the exact rank is known.
KNOWN_RANK_RELATIVE = 2.0**-64

# Least condition over the largest that exact arithmetic may add where axes of numbers as
# written are tilted by round-off, and are made parallel.
CONDITION_OF_TILTS = 1e-9
# Least condition over the largest that exact arithmetic of a geometry inside the digits may add
# to those of floating point; and the same as a power of ten over the digits of the file, where
# joints beside special loops may have relations of their own.
DIGITS_CONDITION = 1e-13
DIGITS_OF_CONDITION = 2.0
# Least condition over the largest, in parts of the rounding of the file, up to which the
# distance of the geometry from one of lower rank is computed.
CONDITION_PER_CHANGE = 100.0
# Distance from a geometry of lower rank, in parts of the rounding of the file, up to which
# rounding explains it: a joint has that of its axis, of its frame, and of the frames before.
ROUNDING_OF_JOINTS = 3.0
# Least condition over the largest above which it does not come from digits.
LARGEST_DIGITS_CONDITION = 1e-6
# Rounding of a file, in parts of the size, up to which its numbers are doubles.
DOUBLE_ROUNDING = 1e-15
# Change of axes with which loops close, in half units of the digits of the file, and radians or
# parts of the size: up to this, rounding explains it.
MENDED_RELATIVE = 100.0
MENDED_ROUND_OFF = 1e-12

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
# Newton decrement at which the nearest design is found: the distance exceeds its minimum by at
# most the square of it. Below the second one, steps may end by round-off.
NEWTON_DECREMENT_LEAST = 1e-12
NEWTON_DECREMENT_STALLED = 1e-7
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
# Violation of mass bounds, relative to them: the accuracy of the conic solver.
BOUND_RELATIVE = 1e-8
# Violation of ball radii, relative to them: the solver keeps second moments to its accuracy
# relative to all of them, and those about a ball's centre may be a thousand times smaller.
REACH_RELATIVE = 1e-6
# Excess of a density over its limit, relative to it: the accuracy of the conic solver.
DENSITY_RELATIVE = 1e-8
# Part by which the solver is asked for more than a limit of density: what it may violate.
DENSITY_TIGHTENED = 5e-8
# The same for the nearest of the designs of a value, which has room for it; and the error of
# the solver up to which it counts.
NEAREST_DENSITY_TIGHTENED = 1e-6
NEAREST_RESIDUAL = 1e-5
# Part of its trace that is added to a matrix that measures a body, so that it is positive
# definite in spite of its round-off.
REFERENCE_RIDGE = 1e-14
# Difference between the second moment of a flat body along its normal and that of a plate,
# relative to it, beside the round-off of all second moments: what a sum of a file keeps.
PLATE_RELATIVE = 1e-6
# Length of a link that counts as zero, in characteristic lengths of the linkage.
LINK_LENGTH_ZERO = 1e-3
# Distances that count as equal where a smallest ball is sought, in characteristic lengths:
# round-off.
BALL_DISTANCE_EQUAL = 1e-12
# Difference of masses, or of lengths of a design, relative to them, up to which they are equal
# where designs are compared: well above the accuracy of the conic solver.
MASSES_EQUAL = 1e-6
# Difference of two densities that count as equal, relative to them: a conic solver leaves 1e-6
# where the least of a determinant is flat, and three digits are written.
DENSITIES_EQUAL = 1e-4
# Smallest eigenvalue of a pseudo-inertia that counts as zero, relative to its trace: below it
# the inverse has no correct digit.
PSEUDO_INERTIA_SINGULAR = 1e-12

# --- added_masses

# Distance outside a region that counts as inside, in its unit coordinates, where half of its
# extent is 1.
INSIDE_REGION = 1e-9
# The same for stationary points of a polynomial: round-off.
STATIONARY_INSIDE = 1e-12
# Part by which the hull of a mesh may hold more than the mesh: facets of doubles and of floats.
MESH_CONVEX = 1e-5
# Smallest extent of a hull of points over the largest: a flatter one has no volume.
HULL_FLAT = 1e-9
# Determinant of the sides of a tetrahedron in unit coordinates: a smaller one is flat.
TETRAHEDRON_FLAT = 1e-12
# Eigenvalue of a quadratic form over its largest entry that counts as zero.
CURVATURE_ZERO = 1e-13
# Coordinate of a joint in its link frame over the length of the link: up to this it is
# round-off of the frames.
COORDINATE_ROUND_OFF = 1e-15

# --- partial balance

# Excess of a bearing force or drive torque over its cap: the accuracy of the conic solver.
CAP_EXCEEDED = 1e-8
# Shaking that matter at a new point would save, relative to that of the file: less adds no
# point. The lightest of the designs of the least shaking may shake by this part more.
LEAST_SHAKING_GAP = 1e-7
# The same for a part of a region with matter of limited density, and of the mass, relative to
# it, where that is least: masses of a flat minimum are known to about the root of it.
LEAST_SHAKING_GAP_FILLED = 1e-10
# Distance of the shaking from its proved bound, relative to the shaking of the file, up to
# which it counts as the least.
SHAKING_GAP_PROVED = 1e-6
# The same for matter of limited density, whose integrals have errors.
FILLING_GAP_PROVED = 1e-5
# Part of the added mass up to which a link gets nothing.
LUMP_SHARE_LEAST = 1e-7
# Price of the whole budget, relative to the shaking of the file, that counts as zero: the
# budget is then larger than needed.
PRICE_ZERO = 1e-6
# Difference between the ends of a motion, relative to its range, up to which it is repeated;
# splines through tables leave less.
MOTION_JOINS = 1e-6
# Size of conditions on added matter that counts as none, over the largest: no such matter has
# a part in them.
CONDITION_WITHOUT_MATTER = 1e-10
# What given masses leave of conditions in which no added matter has a part, over the sum of
# the parts of the bodies: masses in files are rounded.
CONDITION_LEFT = 1e-9
# Mass of a lump over all added mass that is left out: the accuracy of the conic solver.
LUMP_MASS_ZERO = 1e-8
# Distance from the surface of a region, in its unit coordinates, up to which a lump stays on
# it while lumps are refined.
LUMP_ON_SURFACE = 1e-6
# Residual of the conditions over their size up to which lumps are refined: round-off.
LUMP_RESIDUAL = 1e-15
# Error of the moments of lumps, relative to their mass, up to which they are fitted.
LUMP_FIT = 1e-12
# Part of the conditions of a lump that others do not replace, up to which they do: the conic
# solver leaves errors of 1e-9 in the positions of lumps.
LUMPS_ALIKE = 1e-7
# Spread of matter about its centre in unit coordinates, squared, up to which it is one lump.
LUMP_SPREAD = 1e-6
# Residual of the conditions with counterweights over the sum of the parts of the bodies.
COUNTERWEIGHT_RESIDUAL = 1e-10
# Price of a point of a region up to which the dual polynomial counts as not negative, where
# the price of mass is 1.
PRICE_NEGATIVE = 1e-8
# What parts of regions that are filled leave of the conditions, in units of the mean mass of a
# body and of the sizes of the regions; and round-off of their objective, and of its curvature.
FILL_RESIDUAL = 1e-13
FILL_ROUND_OFF = 1e-14
# Gain of their objective that a step predicts, relative to it: below the first few rays tell
# no more, and below the second values have too much round-off to tell whether a step gains.
# Part of the radius up to which the length of a step is that of the radius.
FILL_SETTLED = 1e-5
FILL_VALUE_SURE = 1e-10
FILL_STEP_SOLVED = 0.05
# What a mirror image changes of conditions on matter, relative to them, up to which they are
# symmetric; what balances is judged by all of them.
MIRROR_IMAGE = 1e-11
# Relative gaps of the objective at which Newton's method starts, the next if it fails; of the
# density needed, for forces and for moments; and of the mass that a change of the request
# needs.
FILL_GAPS = (0.1, 1e-3, 1e-6, 1e-8)
MASS_GAP = 1e-5
DENSITY_GAP_FORCE = 1e-7
DENSITY_GAP = 1e-4
# Relative gap of the objective above which the least was not found, and part of the added mass
# up to which a link gets nothing.
FILLING_GAP = 1e-4
FILLED_MASS_ZERO = 1e-9
# Quadratic part of the form of a filled part over its largest entry, up to which a plane bounds
# it: the accuracy of a master program.
CUT_BY_PLANE = 1e-8
# Part of a shift of a form to which it is found; any shift proves a bound.
SHIFT_ACCURACY = 1e-9
# Weight of a moment of inertia in the dual up to which it is not the largest one: the accuracy
# of a master program. And angles in radians at which axes of moments are found, and up to which
# they count where errors of the integrals, of 1e-6, leave no better ones.
MOMENT_WEIGHT_ZERO = 1e-5
AXES_SETTLED = 1e-12
AXES_ACCEPTED = 1e-5
# Share of the mass of a link that counts as none: the accuracy of the solver.
SHARE_ZERO = 1e-7
# Parts of a mass up to which no more is placed than was taken, and of a share up to which it is
# the largest: the accuracy of a master program.
PLACED_AS_TAKEN = 1e-6
# Sine of the angle between a cylinder and the plane of a linkage, or its normal, up to which it
# stands along it.
PLATE_UPRIGHT = 1e-9
# Size of a difference over that of a part up to which it is round-off.
PART_ROUND_OFF = 1e-9
# Largest relative difference of the moments of a part's mesh from those that were computed, of
# which nothing is said: integrals over rays have errors of 1e-5.
PART_MOMENTS = 1e-4
# How far a shape may reach out of its region, over the region: errors of the solver. Distance
# of a shape from a joint, over the shape, up to which it reaches the joint. And the mass of one
# over that of all up to which there is none.
SHAPE_INSIDE = 1e-6
ARM_ZERO = 1e-6
SHAPE_MASS_ZERO = 1e-7
# How far a shape with a web may reach out of its region: both settle to about this, and then
# are moved to meet the conditions.
WEBBED_INSIDE = 1e-5
# Least mass that a certificate of infeasibility excludes, over the given mass.
MASS_EXCLUDED = 1e6
# Part of a certificate that vanishes on balanced distributions only up to this.
CERTIFICATE_ORTHOGONAL = 1e-12
# Differences of lengths, masses and moments of links, over the largest one, and of angles, up
# to which links are alike: what few digits of a file leave. It groups what is tried, and
# decides nothing.
LINKS_ALIKE = 1e-4
# Relative width at which the search for the smallest growth of a region ends.
GROWTH_RELATIVE = 1e-3

# --- remedies

# Size of the conditions on a rotor of unit inertia: up to this its momentum is round-off.
ROTOR_WITHOUT_MOMENTUM = 1e-9
# Weight of a rotor in a certificate, over the size of its matrices: above minus this it counts
# as not negative, and the check of the certificate bears the difference.
ROTOR_WEIGHT_ZERO = 1e-14

# --- springs

# Part of gravity in a unit vector of springs and gravity: below this springs do not carry it.
SPRING_CARRIES_GRAVITY = 1e-8
# Inverse size of springs over the least that their limits allow: below this there are none.
SPRINGS_UNBOUNDED = 1e-7
# Violation of a limit over the size of the unknowns: up to this it is round-off.
SPRING_LIMIT_KEPT = 1e-9
# Stiffness over the largest one: below this there is no spring.
SPRING_ABSENT = 1e-9
# Distance from the middle of a range over half of it: below this it is round-off.
SPRING_IN_MIDDLE = 1e-7
# Torque left over the torque of gravity: up to this springs balance; and torque of gravity over
# that of all weights at the characteristic length: up to this there is none.
SPRING_TORQUE_LEFT = 1e-9

# --- report

# Distance at which points of a drawing coincide, relative to the size of the linkage.
POINT_EQUAL_RELATIVE = 1e-6
# Difference at which joint forces are drawn as one line, relative to the largest force.
FORCE_EQUAL_RELATIVE = 1e-6
# Components of a printed vector that count as zero, relative to the largest one.
COMPONENT_ZERO_RELATIVE = 1e-9
# Negative second moment about the centre of mass that counts as zero, relative to the largest.
SECOND_MOMENT_NEGATIVE_RELATIVE = 1e-9

# --- dynamic_equivalence

# Mass, or first moment in characteristic lengths, over the largest: up to this it is moved.
MASS_LEFT_RELATIVE = 1e-9
# Residual of a condition on pure inertias over the largest of them: up to this it holds.
PURE_INERTIA_CONDITION = 1e-9

# --- identification

# Pivot of the regressor of measured loads, over the largest: up to this the motion does not
# excite a combination of parameters. Loops along a motion are closed to 1e-12.
EXCITED_RELATIVE = 1e-9
# Part of a unit combination of parameters outside those that are excited, up to which it is one
# of them.
EXCITED_OUTSIDE = 1e-6
# Remainder of a row of a basis of unit columns, up to which it depends on the rows before it:
# rows that leave more are taken first, for well-conditioned combinations.
DEPENDENT_ROW_CLEAR = 1e-2
DEPENDENT_ROW = 1e-7
# Coefficient of a combination of parameters, in characteristic lengths, that counts as zero.
COEFFICIENT_ZERO = 1e-9
# Change of the noise of a channel, relative to it, at which its estimate is found.
NOISE_FOUND = 1e-6
# Noise of a channel over the largest load: the least that counts. Loads of a simulation have
# none, and loops along a motion are closed to 1e-12.
NOISE_LEAST = 1e-9
# Smallest eigenvalue of a pseudo-inertia over its trace, in the units of the chain, below which
# a body of a file is taken for flat, and what it is widened by.
PRIOR_FLAT = 1e-6
PRIOR_WIDENED = 1e-4
# Newton decrement, in standard errors, at which the likeliest masses are found. Below the
# second one, steps may end by round-off.
LIKELIEST_DECREMENT = 1e-10
LIKELIEST_STALLED = 1e-4
# Least standard errors of loads, relative to the masses of the file, that count for the
# likeliest masses: larger ones where loads ask for masses so far off that round-off decides.
LIKELIEST_ERRORS = (1e-6, 1e-4, 1e-2, 1.0)
# Correlation of neighbouring residuals above which standard errors are too small.
RESIDUALS_CORRELATED = 0.3
