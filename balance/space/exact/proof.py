"""Proof of the dimension of a design space, as data that anyone can check.

The rank of the conditions is at least that of a minor that does not vanish modulo a prime;
the nullity is at least the number of inertia transfers that are independent modulo a prime,
each of zero momentum by identity. Where both add up to the number of parameters, they are
the rank and the nullity. All numbers in it are whole or rational, none is rounded.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from fractions import Fraction
from hashlib import sha256
from typing import NamedTuple

import numpy as np

from balance.space.exact.chain import ExactChain
from balance.space.exact.modular import eliminate
from balance.space.exact.modular_ranks import Witness
from balance.space.exact.serial import ExactTransfer
from kinematics.numerics.array_types import IntArray
from kinematics.numerics.linalg.cyclotomic import number_remainder

FORMAT = "balance.proof/3"


class Proof(NamedTuple):
    """Lower bounds on rank and nullity that add up to the number of parameters.

    Attributes:
        chain: the linkage in rational numbers.
        witness: rays, and rows and columns of a minor, of the conditions along them.
        transfers: as many independent ones as the nullity is.
        idle: joints that are at rest in every motion. Locked, they leave constraints that
            are as independent as before, so that no motion is lost.
    """

    chain: ExactChain
    witness: Witness
    transfers: tuple[ExactTransfer, ...]
    idle: tuple[int, ...]

    @property
    def rank(self) -> int:
        """Number of independent conditions."""
        return len(self.witness.pivots)

    @property
    def nullity(self) -> int:
        """Dimension of the design space."""
        return len(self.transfers)

    def __repr__(self) -> str:
        """One line: `to_dict` has all of it."""
        return f"Proof(rank={self.rank}, nullity={self.nullity}, prime={self.witness.prime})"

    def to_dict(self) -> dict[str, object]:
        """Convert to plain data, ready for JSON; rational numbers as texts, such as ``"-3/4"``.

        ``sha256`` is that of everything else, as compact JSON with sorted keys.
        """
        body = {
            "format": FORMAT,
            "chain": {name: _plain(value) for name, value in self.chain._asdict().items()},
            "prime": self.witness.prime,
            "rays": _plain(self.witness.rays),
            "pivots": [pivot._asdict() for pivot in self.witness.pivots],
            "transfers": [
                {name: _plain(value) for name, value in transfer._asdict().items()}
                for transfer in self.transfers
            ],
            "idle": list(self.idle),
            "rank": self.rank,
            "nullity": self.nullity,
        }
        text = json.dumps(body, sort_keys=True, separators=(",", ":"))
        return body | {"sha256": sha256(text.encode()).hexdigest()}


def _plain(value: object) -> object:
    """Tuples as lists, rational numbers as texts."""
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return str(value) if isinstance(value, Fraction) else value


def independent_transfers(
    chain: ExactChain, transfers: Sequence[ExactTransfer], p: int
) -> tuple[ExactTransfer, ...]:
    """Select transfers that are independent modulo the prime p, as many as there are.

    They are then independent as rational vectors as well.

    Args:
        chain: the linkage in rational numbers.
    """
    size = len(chain.parameters)
    A: IntArray = np.zeros((len(transfers), len(chain.links) * size), np.int64)
    for row, transfer in zip(A, transfers, strict=True):
        for i, x in enumerate(transfer.z):
            value = number_remainder(x, p)
            for body, sign in ((transfer.target, 1), (transfer.source, -1)):
                if body >= 0:
                    place = body * size + i
                    row[place] = (row[place] + sign * value) % p
    pivots = eliminate(A, A.shape[1], p)
    return tuple(transfers[i] for i in np.flatnonzero(pivots >= 0).tolist())
