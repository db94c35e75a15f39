"""Whether a linkage can balance: the sentence, beside centres of mass and conic programs."""

import re
import shlex
from dataclasses import replace

import numpy as np
import pytest

import balance
from balance.masses.designs.feasibility import feasible
from balance.space.conditions.rank import Decision, NullSpace
from kinematics.closure.joint_positions import joint_positions, si_chain
from kinematics.closure.newton import forward_kinematics
from kinematics.loading.model_gallery import find, load
from tests.support.command_runs import asked
from tests.support.json_answers import json_answer
from tests.support.page_elements import without_breaks

# Balanced, free of forces alone, neither, at first sight (zero momentum in one pose) and open.
GALLERY = (
    "four_bar_kite_balanced",
    "fuga_i",
    "four_bar_general",
    "four_rrr_prototype",
    "double_pendulum_duplicates",
    "four_rrr_in_line",
    "principal_vector_linkage",
    "zero_reaction_arm",
    "sarrus",
    "pantograph_reaction_wheel",
    "four_rrr_symmetric",
)
BODY = (
    '<inertial><origin xyz="0.1 0 0"/><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
)
SLIDER = (
    '<joint name="{0}" type="prismatic"><parent link="{1}"/><child link="{2}"/>'
    '<axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
)
HINGE = (
    '<joint name="{0}" type="continuous"><parent link="{1}"/><child link="{2}"/>'
    '<axis xyz="0 0 1"/></joint>'
)


def tree(*joints):
    """A linkage without loops: joints, each with the link that it moves."""
    links = "".join(f'<link name="{child}">{BODY}</link>' for _, _, _, child in joints)
    lines = "".join(text.format(*names) for text, *names in joints)
    return f'<robot name="tree"><link name="base"/>{links}{lines}</robot>'


@pytest.mark.table(4)
@pytest.mark.parametrize("model", GALLERY)
def test_forces_vanish_where_the_centre_of_mass_stays(model):
    """The centre of mass at closed poses, from displacements of the links alone."""
    linkage, rng = load(model), np.random.default_rng(1)
    chain = si_chain(linkage, True)
    z = np.array([body.inertia for body in linkage.bodies])
    centres = []
    for _ in range(4):
        inputs = dict(zip(linkage.inputs, 0.1 * rng.normal(size=linkage.mobility), strict=True))
        q = joint_positions(linkage, inputs)[chain.joints]
        H = np.concatenate([forward_kinematics(chain, q).H, np.eye(4)[None]])[chain.links]
        centres.append(
            sum(h[:3, :3] @ p[1:4] + p[0] * h[:3, 3] for h, p in zip(H, z, strict=True))
        )
    stays = np.ptp(centres, axis=0).max() < 1e-9 * z[:, 0].sum()
    space = balance.design_space(model)
    answer = space.can_balance
    assert stays == (answer.verdict in ("as_given", "force_alone"))
    assert answer.verb != "remedies" or feasible(space).verdict == "infeasible"
    given = "_balanced" in model or "duplicates" in model or "counter_rotary" in model
    assert (answer.verdict == "as_given") == given


@pytest.mark.parametrize(
    ("joints", "sentence"),
    [
        ([(SLIDER, "s", "base", "block")], "No, only without mass."),
        (
            [(SLIDER, "s", "base", "block"), (HINGE, "r", "base", "wheel")],
            "No, only without mass in block.",
        ),
        (
            [(SLIDER, "s", "base", "block"), (HINGE, "r", "block", "arm")],
            "No, only with masses that add up to nothing.",
        ),
    ],
)
def test_without_mass(joints, sentence, tmp_path):
    """What slides on the base has momentum; the conic program has a certificate of its own."""
    path = tmp_path / "tree.urdf"
    path.write_text(tree(*joints), "utf-8")
    space = balance.design_space(str(path), balance="force")
    assert space.can_balance.verdict == "impossible"
    assert space.can_balance.sentence == f"Can it balance? {sentence}"
    assert feasible(space).verdict == "infeasible"


def test_masses_that_no_body_has(tmp_path):
    """A moment of inertia about the normal alone balances as before, but is that of no body."""
    text = find("four_bar_kite_balanced").read_text("utf-8")
    path = tmp_path / "flat.urdf"
    path.write_text(re.sub(r'(ixx|iyy)="[^"]*"', r'\1="1e-12"', text), "utf-8")
    space = balance.design_space(str(path))
    assert space.as_given.balanced
    assert space.can_balance.verdict == "open"
    assert "which balance it but which no bodies can have" in space.can_balance.sentence


def test_a_file_without_masses(tmp_path):
    text = find("four_bar_general").read_text("utf-8")
    path = tmp_path / "bare.urdf"
    path.write_text(re.sub(r"(?s)<inertial>.*?</inertial>", "", text), "utf-8")
    answer = balance.design_space(str(path)).can_balance
    assert answer.verdict == "open" and "its file has no masses" in answer.sentence


def test_what_is_in_doubt_is_undecided():
    """Balanced masses meet the conditions of one order, which says nothing of the others."""
    space = balance.design_space("four_bar_kite_balanced", max_order=0)
    assert space.can_balance.verdict == "undecided"
    assert "up to order 0, not all" in space.can_balance.sentence
    whole = balance.design_space("four_bar_kite_balanced")
    decision = whole.decision
    doubtful = decision.conditions._replace(dropped=1e-6)
    unsure = replace(whole, decision=Decision(NullSpace(doubtful, decision.basis)))
    assert unsure.doubts and unsure.can_balance.verdict == "undecided"


@pytest.mark.parametrize(
    "words",
    [
        pytest.param(
            ["four_bar_kite_balanced", "--balance", "force", "--as-written"],
            marks=pytest.mark.slow,
        ),
        ["five_bar", "--motion", "u1=2*u2", "--at", "u1=0.1", "--balance", "force"],
        ["four_bar_general", "--max-order", "0", "--bodies", "all"],
        ["fuga_i", "--require", "force; dynamic at u1=0"],
    ],
    ids=lambda words: words[0],
)
def test_the_next_command_runs(words, capsys):
    """The page, the text and the data say the same, and the command is one that works."""
    _, answer = json_answer(capsys, "report", *words)
    printed = asked(["report", *words]).out.splitlines()
    commands = [command for command in (answer["next"], answer["alternative"]) if command]
    shown = [f"{head}{x}" for head, x in zip(("Next: ", "      "), commands, strict=False)]
    assert printed[: len(shown) + 2] == [answer["sentence"], *shown, ""]
    for program, *following in map(shlex.split, commands):
        run = asked(following)
        assert program == "balance" and run.code in (0, 1), run.err


def test_the_page_begins_with_the_sentence(tmp_path, capsys):
    path = tmp_path / "page.html"
    _, answer = json_answer(capsys, "report", "four_bar_general", "--html", str(path))
    page = without_breaks(path.read_text("utf-8"))
    assert f'<p class="lede">{answer["sentence"]}</p>' in page
    assert f"<dd>{answer['next']}</dd>" in page
    assert f"<dd>{answer['alternative']}</dd>" in page


@pytest.mark.parametrize(
    ("words", "alternative"),
    [
        (["five_bar", "--balance", "force"], "balance remedies five_bar --balance force"),
        (["four_bar_kite_balanced"], None),
        (["four_bar_general", "--max-order", "0"], None),
        (["fuga_i", "--require", "force"], None),
    ],
)
def test_remedies_are_an_alternative_to_a_design(words, alternative, capsys):
    """Where masses of the file do not balance a linkage, for all its motions."""
    assert json_answer(capsys, "report", *words)[1]["alternative"] == alternative


def test_modes_and_several_models_have_a_sentence(capsys):
    out = asked(["report", "four_bar_general", "four_bar_kite_balanced"]).out
    assert " ".join(out.split()).count("Can it balance?") == 2
    answers = balance.motion_modes(load("four_bar_general"))
    assert answers.sentence == "Can it balance? No, on every mode of motion."
