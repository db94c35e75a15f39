"""Benchmarks, each named by the claim it tests; ``python -m benchmarks`` runs them all.

Classes and ``time_`` methods follow the naming of airspeed velocity. A class may list
``claims``: a pair of methods and the largest ratio of their times that the claim allows, or
one method and the largest value of it; and it may have a method ``row``, whose results are
printed as a table. Only ratios within one run mean anything, since the machine may be shared.
``python -m benchmarks.against COMMIT`` compares design spaces with those of another commit.
"""
