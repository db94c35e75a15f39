"""``<coupling>`` of URDF+, the format whose ``<loop>`` is read.

With the chains from the nearest common ancestor of two links to the predecessor and to the
successor, ``ratio × Σ q (predecessor chain) = Σ q (successor chain)``; see the constraint
matrix of ROAM-Lab-ND/generalized_rbda. A ``<mimic>`` says the same if a joint moves in each.
"""

from __future__ import annotations

from kinematics.files.formats.loop_dialects.draft import (
    Draft,
    check_spelling,
    end_name,
    read_numbers,
)
from kinematics.files.formats.loop_dialects.joint_relations import follow_joint
from kinematics.files.urdf.validate_fields import check_only
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element


def translate_coupling(draft: Draft, item: Element) -> None:
    """Translate a ``<coupling>`` to a ``<mimic>``.

    Args:
        draft: the tree of the file, of which a joint gets the ``<mimic>``.

    Raises:
        Refusal: it does not say enough, or relates sums of several joints.
    """
    check_spelling(item, item, "predecessor", "successor", "ratio", "name")
    ends = []
    for role in ("predecessor", "successor"):
        name = end_name(item, role)
        if check_only(item, role) is None or name not in draft.links:
            problem = f"no <{role}> that names a link of the file"
            raise Refusal(item.label, problem, f'write <{role} link="…"/>')
        ends.append(name)
    given = check_only(item, "ratio")
    text = given.attributes.get("value", "") or given.text if given is not None else ""
    if given is None or not text:
        raise Refusal(item.label, 'no <ratio value="…"/>', "add it")
    (ratio,) = read_numbers(item, given, text, 1)
    chains = _chains(draft, *ends)
    if not all(len(chain) == 1 for chain in chains):
        counts = " and ".join(str(len(chain)) for chain in chains)
        problem = f"it relates sums of joint positions ({counts} joints), which is not read"
        remedy = (
            'write <mimic joint="…" multiplier="…"/> in a joint that follows one other joint; '
            "one that follows several is that many joints about one axis, each with a <mimic>"
        )
        raise Refusal(item.label, problem, remedy)
    (source,), (follower,) = chains
    follow_joint(draft, item, (follower.name, source.name), ratio, "0")


def _chains(draft: Draft, predecessor: str, successor: str) -> list[list[Element]]:
    """Moving joints from the nearest common ancestor to each of two links."""
    first, second = (list(draft.moving_joints(link))[::-1] for link in (predecessor, successor))
    while first and second and first[0].name == second[0].name:
        first, second = first[1:], second[1:]
    return [first, second]
