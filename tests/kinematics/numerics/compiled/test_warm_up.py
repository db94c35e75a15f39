"""The warm-up of a package runs everything that has kernels."""

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
