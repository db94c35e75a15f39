"""Four-bars that stand on each other: freedoms, balance, constant inertia, positions."""

from __future__ import annotations

import numpy as np
import pytest

from balance import verify
from balance.momentum import momentum_regressor
from balance.motion import from_tool_csv
from balance.space import locked_inertia
from balance.studies import StackedFourBar, four_bar_stack_urdf
from kinematics import load
from kinematics.closure.joint_positions import si_chain
from kinematics.closure.newton import forward_kinematics
from kinematics.errors import UsageError
from kinematics.model.document.element import Document

MIXED = (StackedFourBar("kite", 0.2, 2.5, -1.0, 0.4), StackedFourBar(crank=0.1, ratio=2.2))
STACKS = {"three": None, "mixed": MIXED, "one": (StackedFourBar("kite", ratio=1.8),)}


def stack_of(modules):
    # Kites of these sizes take denser matter than steel.
    urdf = four_bar_stack_urdf(modules, density=None) if modules else four_bar_stack_urdf()
    return load(Document("stack", urdf))


@pytest.fixture(scope="module", params=STACKS.values(), ids=STACKS)
def stack(request):
    return stack_of(request.param)


def poses_of(linkage, count):
    rng = np.random.default_rng(2)
    for _ in range(count):
        yield dict(zip(linkage.inputs, rng.uniform(-0.4, 0.4, linkage.mobility), strict=True))


def test_it_has_no_momentum_and_a_constant_inertia_on_its_base(stack):
    """In random poses, by the momentum of all inputs and by the inertia with joints locked."""
    bodies = np.concatenate([body.inertia for body in stack.bodies])
    assert min(body.inertia[0] for body in stack.bodies) > 0.0
    still = locked_inertia(stack, dict.fromkeys(stack.inputs, 0.0))
    for pose in poses_of(stack, 3):
        momenta = momentum_regressor(stack, pose, spatial=True) @ bodies
        assert np.abs(momenta).max() < 1e-10 * np.abs(still).max()
        assert np.abs(locked_inertia(stack, pose) - still).max() < 1e-10 * np.abs(still).max()


def test_its_links_can_be_built(stack):
    """Mass and moment of inertia about the own centre are positive."""
    for body in stack.bodies:
        mass, x, y, _, _, _, moment, *_ = body.inertia
        at = np.array([x, y]) / mass
        assert moment - mass * at @ at > 0.0


def test_each_four_bar_adds_a_freedom_of_the_tool():
    """With three the tool goes in all directions and turns: the Jacobian has rank 3."""
    linkage = stack_of(None)
    assert linkage.mobility == 3 and linkage.planar
    X = momentum_regressor(linkage, dict.fromkeys(linkage.inputs, 0.0)).reshape(3, 3, -1, 4)
    number = [body.name for body in linkage.bodies].index("coupler_3")
    # Per kg at the frame of the body, and per kg m²: velocity and rate of turn.
    velocity, turn = X[:, 1:, number, 0], X[:, 0, number, 3]
    assert np.linalg.cond(np.column_stack([velocity, turn])) < 1e3


@pytest.mark.slow
def test_the_tool_goes_through_positions_without_shaking(tmp_path):
    """A path to other places and angles; where the tool is by forward kinematics."""
    linkage = stack_of(None)
    time = np.linspace(0.0, 1.0, 101)
    ramp = 0.5 - 0.5 * np.cos(np.pi * time)
    goal = np.array([0.04, -0.03, 0.25])
    rows = "\n".join(
        f"{t:.2f},{x:.12f},{y:.12f},{a:.12f}"
        for t, (x, y, a) in zip(time, np.outer(ramp, goal), strict=True)
    )
    (tmp_path / "tool.csv").write_text(f"time,x,y,rz\n{rows}\n")
    moved = from_tool_csv(linkage, tmp_path / "tool.csv", "tool")
    chain, place = si_chain(linkage, spatial=True), linkage.places["tool"]
    start, end = (
        forward_kinematics(chain, q).H[place.link] @ place.pose for q in moved.q[[0, -1]]
    )
    assert np.abs(end[:2, 3] - start[:2, 3] - goal[:2]).max() < 1e-8
    turned = np.arctan2(*(end[:2, :2] @ start[:2, :2].T)[::-1, 0])
    assert turned == pytest.approx(goal[2], abs=1e-8)
    checked = verify(linkage, motions=[moved])
    assert checked.balanced
    assert max(checked.force_residual, checked.moment_residual) < 1e-10


@pytest.mark.slow
def test_random_motions_of_all_freedoms_do_not_shake(stack):
    checked = verify(stack, trajectories=2)
    assert checked.balanced and checked.moment_residual < 1e-10


def test_masses_of_a_four_bar_that_carries_nothing_are_wrong_below_another():
    """A load that the coupler does not give up shakes, although each is balanced alone."""
    text = four_bar_stack_urdf(MIXED, density=None).decode()
    alone = four_bar_stack_urdf(MIXED[:1], density=None).decode()

    def link(text):
        return text[text.index('<link name="coupler_1">') :].partition("</link>")[0]

    mixed = load(Document("mixed", text.replace(link(text), link(alone)).encode()))
    bodies = np.concatenate([body.inertia for body in mixed.bodies])
    still = dict.fromkeys(mixed.inputs, 0.1)
    momenta = momentum_regressor(mixed, still, spatial=True) @ bodies
    sizes = np.abs(momenta).max(axis=1)
    assert sizes[0] > 1e-3 and sizes[1] < 1e-10


@pytest.mark.parametrize(
    ("modules", "said"),
    [
        ((), "one to 6 four-bars"),
        ((StackedFourBar(),) * 7, "one to 6 four-bars"),
        ((StackedFourBar("rhombus"),), "four-bar 1 of the stack: kind 'rhombus'"),
        ((StackedFourBar(), StackedFourBar(ratio=1.3)), "four-bar 2 .* no masses"),
        ((StackedFourBar(crank_angle=np.pi),), "flat"),
        ((StackedFourBar(crank=-0.1),), "a crank with a length"),
        ((StackedFourBar(ratio=float("nan")),), "finite"),
        ((StackedFourBar("kite", ratio=1.8),), "no matter of at most 7850"),
    ],
)
def test_stacks_that_cannot_be_are_refused(modules, said):
    with pytest.raises(UsageError, match=said):
        four_bar_stack_urdf(modules)
