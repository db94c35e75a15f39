"""Benchmarks, each named by the claim it tests; ``python -m benchmarks`` runs them all.

Classes and ``time_`` and ``track_`` methods follow the naming of airspeed velocity; beside a
time stands an error against exact arithmetic, mpmath or another independent route. A class may
list ``claims``: a pair of methods and the largest ratio of their times that the claim allows,
or one method and the largest value of it. What it tracks may be the seconds of several runs.
It may have a method ``row``, whose results are printed as a table. Setting up, tracking or a
row may raise NotImplementedError where a library is missing, and is left out then. Only ratios
within one run mean anything, since the machine may be shared. The lines of
`benchmarks.harness.table` are printed at the end of a run. ``python -m benchmarks.against
COMMIT`` compares design spaces with those of another commit.
"""
