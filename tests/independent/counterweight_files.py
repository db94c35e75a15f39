"""Files with counterweights, checked by the commands that read them.

``python -m tests.independent.counterweight_files --cases 20 --balance dynamic`` checks those of
all feasible requests among so many.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import tempfile
from pathlib import Path

import numpy as np

import balance
from balance.app.cli.main import main as main_of_balance
from balance.masses.counterweights.write_counterweights import with_counterweights
from tests.independent.counterweight_requests import random_request
from tests.support.points import point_counterweights


def export_fault(found, path: Path, merge: bool) -> str:
    """What is wrong with the file of counterweights; empty if it is balanced by every check.

    The report of the file must say so with ten parameters for each body where the request
    counted them, `verify` must exit with 0, and the bodies must have the momentum they were
    designed with.
    """
    path.write_bytes(with_counterweights(found, merge=merge))
    counted = ["--balance", found.space.balance]
    spatial = ["--spatial"] if "Exx" in found.space.labels else []
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()):
        code = main_of_balance(["report", str(path), "--json", *counted, *spatial])
        report = json.loads(out.getvalue())
        verified = main_of_balance(["verify", str(path), "--trajectories", "1", *counted])
    if code != 0 or not report["as_given"]["balanced"]:
        return f"the report says {report['as_given']}"
    if verified != 0:
        return f"verify exits with {verified}"
    space = balance.design_space(str(path), balance=found.space.balance)
    off = np.abs(np.array([body.inertia for body in space.linkage.bodies]) - found.z).max()
    if off > 1e-12 * np.abs(found.z).max():
        return f"parameters differ by {off:.1e}"
    return ""


def check_exports(seeds, folder: Path, balanced: str) -> int:
    """Check the files of all feasible requests among some, and return how many are wrong."""
    bad = count = 0
    for seed in seeds:
        space, add, texts = random_request(seed, folder / f"{seed}.urdf", balanced)
        found = point_counterweights(space, add, texts, relax=False)
        for merge in (False, True) if found.verdict == "feasible" else ():
            fault, count = export_fault(found, folder / "out.urdf", merge), count + 1
            bad += bool(fault)
            if fault:
                print(f"seed {seed}, {'merged' if merge else 'own links'}: {fault}", flush=True)
    print(f"{count} files of {len(seeds)} requests, {bad} not balanced")
    return bad


def main() -> None:
    """Check files and print how many are wrong."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--cases", type=int, default=20)
    parser.add_argument("--balance", choices=("force", "dynamic"), default="force")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        raise SystemExit(
            bool(check_exports(range(options.cases), Path(folder), options.balance))
        )


if __name__ == "__main__":
    main()
