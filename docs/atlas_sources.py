"""What the atlas says beside its searches: introduction, sources, and who described what."""

HEAD = """# Atlas of special geometries

Linkages that balance by their geometry: families of geometries whose design space is larger
than that of most geometries of their topology. `python docs/make_atlas.py --work FOLDER` made
this page from searches with seed 1 ([Discovery](discovery.md) explains them); `balance
discover run --topology NAME --starts N` repeats one of them.

Joints go by letters in the order of the line of each topology: `A R 0-1` is a revolute joint
between links 0 and 1, and AB the distance of A and B on the link that both are on. A family
is found by walks from random geometries, so that nothing proves a list complete, unless a
source is named. **Masses**: for how many random members bodies can be built that balance.
**Least mass**: of all moving links of the member drawn, whose joints are at a root mean
square distance of 1 m from their middle, if the coupler (the link off the ground with the
most joints) has at least 1 kg. **Motion**: how far a joint on the ground drives the member
drawn before a dead point of that drive, or a pose where two motions meet. Six-bars that one
special loop of four links explains are left out.
"""

KNOWN = "R. Ricard and C. M. Gosselin (2000)"
COMPLETE = "the list is complete: B. Moore, J. Schicho and C. M. Gosselin (2009)"

FIRST = (
    ("four-bar", ("AD = BC", "AB = CD"), 5, f"antiparallelogram: {KNOWN}; {COMPLETE}"),
    ("four-bar", ("AD = AB", "BC = CD"), 5, f"kite: {KNOWN}; {COMPLETE}"),
    (
        "four-bar",
        ("AD = BC", "AB = CD"),
        7,
        f"parallelogram; no masses can be built without counter-rotation: {COMPLETE}",
    ),
)
"""Topology, relations, nullity, and who described the family first."""

SOURCES = """## Sources

- R. Ricard and C. M. Gosselin, On the development of reactionless parallel manipulators, ASME
  DETC2000/MECH-14098, 2000: kite and antiparallelogram with masses.
- C. M. Gosselin, B. Moore and J. Schicho, Dynamic balancing of planar mechanisms using toric
  geometry, Journal of Symbolic Computation 44, 2009, [arXiv
  0711.3742](https://arxiv.org/abs/0711.3742), and B. Moore, J. Schicho and C. M. Gosselin,
  Determination of the complete set of shaking force and shaking moment balanced planar
  four-bar linkages, Mechanism and Machine Theory 44, 2009: all balanced four-bars.
- B. Moore, Dynamic balancing of linkages by algebraic methods, PhD thesis, Johannes Kepler
  University Linz, 2009: proves that no spherical four-bar is balanced dynamically by masses
  of its links. The special spherical geometries above have more masses without momentum, but
  none that can be built.
- Y. Wu and C. M. Gosselin, Synthesis of reactionless spatial 3-DoF and 6-DoF mechanisms
  without separate counter-rotations, International Journal of Robotics Research 23, 2004:
  spatial mechanisms that are made of balanced planar four-bars.
- G. Feng, Complete shaking force and shaking moment balancing of four types of six-bar
  linkages, Mechanism and Machine Theory 24, 1989, and I. S. Kochev, General theory of
  complete shaking moment balancing of planar linkages: a critical review, Mechanism and
  Machine Theory 35, 2000: six-bars, balanced with counter-rotating bodies.

For all other families an index of public web pages was searched in November 2026 for
dynamically balanced, reactionless and inherently balanced six-bar, Watt, Stephenson,
slider-crank, geared five-bar, spherical and spatial linkages without counter-rotations, and
for the names above. No description of them was found, in abstracts and the pages of that
index alone: papers behind a paywall were not read, so that nothing here claims that a family
is new.
"""
