"""Benchmarks, each named by the claim it tests; ``python -m benchmarks`` runs them all.

Classes and ``time_`` and ``track_`` methods follow the naming of airspeed velocity. Beside each
time, an error against exact arithmetic, mpmath or another independent route is tracked. The
attribute ``claims`` of a class lists a pair of methods and the largest ratio of their times,
or one method and its largest value. A ``track_`` method may return the seconds of several
runs. The results of a method ``row`` are printed as a table. Setup, a tracked value or a row
that raises NotImplementedError, because a library is missing, is left out. Only ratios within
one run are meaningful, since the machine may be shared. The lines of `benchmarks.harness.table`
are printed at the end of a run. ``python -m benchmarks.against COMMIT`` compares design spaces
with those of another commit, or with ``--sweeps`` a geometry of a sweep; ``python -m
benchmarks.profiles NAME`` profiles a claim.
"""
