"""Studies that are changed: their values, tables and bytes; and topologies."""

from __future__ import annotations

import datetime
import json
import math
import random
from typing import Any

from balance.studies.discovery.topologies import TOPOLOGIES
from tests.fuzz.json_mutants import changed
from tests.fuzz.mutant_bytes import cut, cut_out, insert, repeat_span

# Studies of few geometries that use all tables, and most kinds of values.
STUDIES: tuple[dict[str, Any], ...] = (
    {
        "model": {"file": "four_bar_kite"},
        "parameters": {"rocker.length": [0.9, 1.0], "q4.origin.x": "0.9:1.1:3"},
        "relations": {"coupler.length": "rocker.length*0.7"},
        "constraints": {"assembles": "anywhere", "grashof": True, "transmission": 5,
                        "conditions": ["rocker.length < 5"]},
        "compute": {"quantities": ["rank"], "balance": "dynamic", "spatial": False},
        "run": {"chunk_rows": 2},
    },
    {
        "model": {"file": "four_bar_general", "bodies": "all", "massless": [],
                  "at": {"u1": 0.1}, "angles": "nominal", "inputs": ["u1"]},
        "parameters": {"a": {"uniform": [0.9, 1.1]},
                       "q4": {"origin": {"x": {"normal": [1.0, 0.01]}}}},
        "relations": {"rocker.length": "a"},
        "sampling": {"count": 3, "seed": 5},
        "constraints": {"transmission": {"joint": "q4", "least": 1},
                        "reach": {"link": "coupler", "point": [0, "a", 0],
                                  "targets": [[0.5, 0.5, 0]]}},
        "compute": {"quantities": ["rank", "design"], "balance": "force",
                    "design": {"where": "rank drop"}},
    },
    {
        "model": {"file": "slider_crank"},
        "parameters": {"coupler.length": {"sobol": [2.0, 2.2]}},
        "sampling": {"count": 2},
        "compute": {"quantities": ["singular_values", "orders", "shaking", "input_inertia"],
                    "orders": {"count": 3}, "shaking": {"poses": [[0.0], [0.2]], "samples": 5}},
    },
    {
        "model": {"file": "four_bar_general"},
        "parameters": {"rocker.mass": [1.0, 2.0]},
        "compute": {"quantities": ["distance", "design", "counterweights"],
                    "design": {"minimise": "mass", "keep": ["coupler"], "within": 0.1,
                               "bounds": {"rocker": [0.1, 3.0]}},
                    "counterweights": {"links": ["crank"],
                                       "regions": {"crank": "ball(0,0,0,1)"}}},
    },
)  # fmt: skip
SPANS = (cut, cut_out, insert, repeat_span)


def study_text(rng: random.Random) -> bytes:
    """Write a study with changes."""
    study: Any = rng.choice(STUDIES)
    for _ in range(rng.choice((0, 1, 1, 1, 2, 3))):
        study = changed(rng, study)
    tables = study if isinstance(study, dict) else {"model": study}
    text = "\n".join(f"{_key(key)} = {_toml(value)}" for key, value in tables.items())
    data = text.encode("utf-8", "replace")
    return rng.choice(SPANS)(rng, data) if rng.random() < 0.15 else data


def _key(key: str) -> str:
    return json.dumps(str(key), ensure_ascii=False)


def _toml(value: Any) -> str:
    """Write a value as TOML, tables and all in one line; nothing becomes an empty text."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {_toml(x)}" for k, x in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, datetime.date | datetime.time):
        return value.isoformat()
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return '""' if value is None else json.dumps(value, ensure_ascii=False)


def random_topology(rng: random.Random) -> str:
    """Name or write a topology, good or bad."""
    if rng.random() < 0.2:
        return rng.choice(
            (
                *TOPOLOGIES,
                "",
                " ",
                "x",
                "plane:",
                "space:",
                "0-1\n1-2 2-0",
                "0-0",
                "0-1",
                "space: S0-1 1-2",
                f"0-1 1-{'9' * 5000}",
            )
        )
    if rng.random() < 0.4:
        name = rng.choice(list(TOPOLOGIES))
        pairs = [f"{kind}{a}-{b}" for kind, a, b in TOPOLOGIES[name].edges]
        space = TOPOLOGIES[name].space
    else:
        links = rng.choice((2, 3, 4, 4, 5, 6, 7, 11))
        pairs = [f"{rng.choice('RRRRPUS')}{rng.randrange(k)}-{k}" for k in range(1, links)]
        for _ in range(rng.choice((0, 1, 1, 1, 2, 2, 3))):
            pairs.append(f"{rng.choice('RRRP')}{rng.randrange(links)}-{rng.randrange(links)}")
        space = rng.choice(("plane", "plane", "plane", "sphere", "space", "hyper"))
    if pairs and rng.random() < 0.4:
        k = rng.randrange(len(pairs))
        pairs[k] = rng.choice(
            (
                pairs[0],
                "",
                "0-1",
                "P0-1",
                "0-99",
                "x",
                "1-",
                "R1-1",
                "٣-1",
                f"U{pairs[k][1:]}",
                f"P{pairs[k].lstrip('RPUS')}",
                f"0-{10**25}",
            )
        )
    return " ".join(
        [*([f"{space}:"] if space != "plane" or rng.random() < 0.1 else []), *pairs]
    )
