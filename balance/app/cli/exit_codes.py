"""Exit codes of the command line."""

from __future__ import annotations

DONE = 0
# A verdict: not balanced, infeasible, or a pose that is not reached.
NEGATIVE = 1
USAGE = 2
# Bad input, or a mechanism that is refused.
REFUSED = 3
# Two routes disagree, an integer may be wrong, or it is less certain than asked for.
UNDECIDED = 4
# An unexpected exception.
DEFECT = 70
# The convention of shells: 128 + SIGINT.
INTERRUPTED = 130

EXPLANATION = (
    "Exit codes: 0 done, 1 a negative verdict, 2 usage, 3 bad input or a refused mechanism, "
    "4 undecided, 70 a defect of this program (one line says what; BALANCE_DEBUG=1 shows "
    "where), 130 interrupted."
)


def verdict_code(verdict: str) -> int:
    """Return the exit code of a verdict on masses that can be built."""
    return {"feasible": DONE, "optimal": DONE, "infeasible": NEGATIVE}.get(verdict, UNDECIDED)
