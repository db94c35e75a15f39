"""The warm-up of a package runs everything that has kernels."""

import pytest

import balance.app.warmup as balance_warmup
from kinematics.loading import warmup


def test_kinematics_alone_warms_up_single_and_many_poses(monkeypatch):
    linkages, expanded, expanded_at_many = warmup.smallest_linkages(), [], []
    monkeypatch.setattr(warmup, "smallest_linkages", lambda: linkages)
    monkeypatch.setattr(
        warmup, "taylor_motion", lambda linkage, order: expanded.append(linkage)
    )
    monkeypatch.setattr(
        warmup,
        "taylor_motion_many",
        lambda linkage, poses, order: expanded_at_many.append(linkage),
    )
    assert sum(1 for _ in warmup.warm_up_kinematics()) > len(linkages)
    assert all(linkage in expanded for linkage in linkages)
    assert expanded_at_many == linkages


@pytest.mark.parametrize(("verb", "first"), [("verify", "_follow"), ("report", "_find_space")])
def test_the_kernels_that_a_command_needs_come_first(verb, first, monkeypatch):
    run = []
    monkeypatch.setattr(
        balance_warmup, "_run_stages", lambda _, *stages: run.extend(stages) or ()
    )
    monkeypatch.setattr(balance_warmup, "waiting_verb", lambda: verb)
    assert list(balance_warmup.warm_up_single([])) == []
    assert run[0].__name__ == first and len({*run}) == len(run) == 5
