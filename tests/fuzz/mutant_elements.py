"""Changes of the elements, attributes and numbers of a URDF file."""

from __future__ import annotations

import copy
import random
from collections.abc import Callable
from xml.etree import ElementTree

Tree = ElementTree.Element
Change = Callable[[random.Random, Tree], None]

KINDS = (
    "fixed",
    "revolute",
    "continuous",
    "prismatic",
    "universal",
    "cylindrical",
    "planar",
    "spherical",
)
ODD_TYPES = ("floating", "ball", "Revolute", "screw", "", "revolute ", "gear", "1")
NUMBERS = ("0", "-0", "1", "-1", "0.5", "1e-3", "25.4", "1e-9", "-2.5e2", "1.5708", "3.14159",
    "1.0471975511965976", "1e6", "1e-200", "1e29", "-1e30", "+.5", "7.", "0.1E+1")  # fmt: skip
ODD_NUMBERS = ("nan", "inf", "-inf", "1e999", "${x}", "$(arg x)", "2,5", "", "x", "0x1", "1_0",
    "1e31", "٣", "1d0", "--1", "pi/2", "1 kg", "NaN", "1e-400", "−1", "9" * 400)  # fmt: skip
NAMES = ("", " ", "x", "base", "a b", "naïve", "连杆", "😀", "é", "é", "a/b", "j.0", "on", "1",
    "<", "&", "'", '"', "\u202e", "\u00a0", "n" * 300, "-1", "ground", "u1")  # fmt: skip
FOREIGN = (
    "<limit lower='0' upper='x'/>",
    "<dynamics damping='0,1'/>",
    "<gazebo><a/></gazebo>",
    "<visual><geometry><mesh filename='a'/></geometry></visual>",
    "<sensor name='s'/>",
    "<transmission name='t'><joint name='j'/></transmission>",
    "<calibration rising='?'/>",
    "<coupling name='c'/>",
    "<loop_joint name='k'/>",
    "<note>text</note>",
)


def _some(rng: random.Random, tree: Tree, *tags: str) -> Tree | None:
    """An element with one of these tags, at any depth; of all by default."""
    found = [item for item in tree.iter() if not tags or item.tag in tags]
    return rng.choice(found) if found else None


def _holder(tree: Tree, item: Tree) -> Tree:
    """What holds an element; the root for the root."""
    return next((other for other in tree.iter() if item in list(other)), tree)


def _part(rng: random.Random, tree: Tree) -> tuple[Tree, Tree]:
    """An element that is not the root, and what holds it."""
    holders = [item for item in tree.iter() if len(item)]
    holder = rng.choice(holders) if holders else ElementTree.SubElement(tree, "link")
    return (rng.choice(list(holder)), holder) if len(holder) else (holder, tree)


def typo(rng: random.Random, word: str) -> str:
    """A word as fingers may write it."""
    i = rng.randrange(max(len(word) - 1, 1))
    return rng.choice(
        (
            word[:i] + word[i + 1 :] or "x",
            word[:i] + word[i + 1 : i + 2] + word[i:],
            word + "s",
            word[:i] + word[i : i + 1] + word[i:],
            word.upper(),
            word.capitalize(),
            word[:i] + word[i + 1 : i + 2] + word[i : i + 1] + word[i + 2 :],
        )
    )


def drop_element(rng, tree):
    item, holder = _part(rng, tree)
    holder.remove(item) if item in list(holder) else None


def repeat_element(rng, tree):
    item, holder = _part(rng, tree)
    holder.insert(rng.randrange(len(holder) + 1), copy.deepcopy(item))


def misspell_element(rng, tree):
    item = _some(rng, tree)
    item.tag = typo(rng, item.tag)


def drop_attribute(rng, tree):
    item = _some(rng, tree)
    if item.attrib:
        del item.attrib[rng.choice(sorted(item.attrib))]


def misspell_attribute(rng, tree):
    item = _some(rng, tree)
    if item.attrib:
        name = rng.choice(sorted(item.attrib))
        item.attrib[typo(rng, name)] = item.attrib.pop(name)


def _numbers(rng, tree):
    """An element with numbers, and the attribute that has them."""
    known = ("xyz", "rpy", "value", "ixx", "iyy", "izz", "ixy", "multiplier", "offset")
    found = [(i, a) for i in tree.iter() for a in known if a in i.attrib]
    return rng.choice(found) if found else (tree, "value")


def change_number(rng, tree):
    item, name = _numbers(rng, tree)
    words = item.get(name, "0").split() or ["0"]
    words[rng.randrange(len(words))] = rng.choice(NUMBERS)
    item.set(name, " ".join(words))


def odd_number(rng, tree):
    item, name = _numbers(rng, tree)
    words = item.get(name, "0").split() or ["0"]
    words[rng.randrange(len(words))] = rng.choice(ODD_NUMBERS)
    item.set(name, rng.choice((" ", " ", " ", ", ", "\n", "\t")).join(words))


def change_count(rng, tree):
    item, name = _numbers(rng, tree)
    words = item.get(name, "0").split()
    item.set(name, " ".join(words[1:] if rng.random() < 0.5 else [*words, "0"]))


def zero_vector(rng, tree):
    item, name = _numbers(rng, tree)
    item.set(name, " ".join("0" for _ in item.get(name, "").split()))


def stretch_axis(rng, tree):
    item = _some(rng, tree, "axis")
    if item is not None:
        factor = rng.choice((25.4, -1.0, 1e-90, 1e20, 1e-3))
        words = item.get("xyz", "0 0 1").split()
        try:
            item.set("xyz", " ".join(repr(factor * float(word)) for word in words))
        except ValueError:
            item.set("xyz", "0 0 1")


def turn_joint(rng, tree):
    item = _some(rng, tree, "origin")
    if item is not None:
        words = ("0", "1.5708", "3.14159", "0.3", "-0.7", "1.5707963267948966")
        item.set("rpy", " ".join(rng.choice(words) for _ in range(3)))


def random_axis(rng, tree):
    item = _some(rng, tree, "axis", "axis2")
    if item is not None:
        item.set("xyz", " ".join(f"{rng.uniform(-1, 1):.3f}" for _ in range(3)))


def swap_ends(rng, tree):
    item = _some(rng, tree, "joint", "loop")
    if item is not None and len(item) > 1:
        ends = [side for side in item if "link" in side.attrib]
        if len(ends) == 2:
            first, second = (side.get("link") for side in ends)
            ends[0].set("link", second)
            ends[1].set("link", first)


def swap_links(rng, tree):
    sides = [side for side in tree.iter() if "link" in side.attrib]
    if len(sides) > 1:
        one, other = rng.sample(sides, 2)
        first, second = one.get("link"), other.get("link")
        one.set("link", second)
        other.set("link", first)


def reparent(rng, tree):
    side = _some(rng, tree, "parent", "child", "predecessor", "successor")
    names = [link.get("name", "") for link in tree.iter("link")]
    if side is not None and names:
        side.set("link", rng.choice((*names, "nowhere")))


def retype(rng, tree):
    item = _some(rng, tree, "joint", "loop")
    if item is not None:
        item.set("type", rng.choice((*KINDS, *KINDS, *KINDS, *ODD_TYPES)))


def nest(rng, tree):
    item, holder = _part(rng, tree)
    other = _some(rng, tree)
    if item in list(holder) and other not in list(item.iter()):
        holder.remove(item)
        other.append(item)


def bury(rng, tree):
    item, holder = _part(rng, tree)
    if item in list(holder):
        place = list(holder).index(item)
        holder.remove(item)
        tag = rng.choice(("group", "gazebo", "link", "origin", item.tag, "transmission"))
        wrap = ElementTree.Element(tag)
        wrap.append(item)
        holder.insert(place, wrap)


def lift(rng, tree):
    item, holder = _part(rng, tree)
    if item in list(holder):
        holder.remove(item)
        tree.append(item)


def shuffle(rng, tree):
    item = rng.choice((tree, tree, _some(rng, tree)))
    item[:] = rng.sample(list(item), len(item))


def rename(rng, tree):
    """A name, here and wherever it is meant: nothing else changes."""
    item = _some(rng, tree, "link", "joint", "loop")
    if item is None:
        return
    old, new = item.get("name", ""), rng.choice(NAMES)
    item.set("name", new)
    wanted = "joint" if item.tag == "joint" else "link"
    for side in tree.iter():
        if side.get(wanted) == old and item.tag != "loop":
            side.set(wanted, new)


def misname(rng, tree):
    item = _some(rng, tree, "link", "joint", "loop", "robot")
    if item is not None:
        names = [other.get("name", "") for other in tree.iter(item.tag)]
        item.set("name", rng.choice((*NAMES, *names)))


def mimic(rng, tree):
    joints = tree.findall("joint")
    if joints:
        item = rng.choice(joints)
        follows = {"joint": rng.choice(joints).get("name", "")}
        for name in ("multiplier", "offset"):
            if rng.random() < 0.6:
                follows[name] = rng.choice(NUMBERS)
        ElementTree.SubElement(item, "mimic", follows)


def pitch(rng, tree):
    item = _some(rng, tree, "joint")
    if item is not None:
        value = rng.choice((*NUMBERS, "0.01", "0.002"))
        ElementTree.SubElement(item, "screw_thread_pitch", {"value": value})


def independent(rng, tree):
    for item in rng.sample(tree.findall("joint"), min(2, len(tree.findall("joint")))):
        item.set("independent", rng.choice(("true", "true", "false", "True", "1", "")))


def second_axis(rng, tree):
    item = _some(rng, tree, "joint", "loop")
    if item is not None:
        item.set("type", rng.choice(("universal", "universal", "revolute")))
        first = item.find("axis")
        across = "0 1 0" if first is None or first.get("xyz") == "0 0 1" else "1 0 0"
        ElementTree.SubElement(item, "axis2", {"xyz": rng.choice((across, "0 1 1"))})


def add_frame(rng, tree):
    """A link with mass, fixed to another."""
    links = tree.findall("link")
    if not links:
        return
    name, parent = f"f{rng.randrange(10**6)}", rng.choice(links).get("name", "")
    link = ElementTree.SubElement(tree, "link", {"name": name})
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", {"xyz": "0.1 0 0.2", "rpy": "0.3 0 0.1"})
    ElementTree.SubElement(inertial, "mass", {"value": rng.choice(NUMBERS)})
    entries = dict.fromkeys(("ixx", "iyy", "izz"), "0.1")
    ElementTree.SubElement(inertial, "inertia", entries)
    kind = rng.choice(("fixed", "fixed", *KINDS))
    joint = ElementTree.SubElement(tree, "joint", {"name": f"j{name}", "type": kind})
    ElementTree.SubElement(joint, "origin", {"xyz": "0.1 0.2 0", "rpy": "0 0.4 0"})
    ElementTree.SubElement(joint, "parent", {"link": parent})
    ElementTree.SubElement(joint, "child", {"link": name})


def add_loop(rng, tree):
    links = tree.findall("link")
    if links:
        kind = rng.choice((*KINDS, "spherical"))
        loop = ElementTree.SubElement(tree, "loop", {"name": "extra", "type": kind})
        for role in ("predecessor", "successor"):
            name = rng.choice(links).get("name", "")
            ElementTree.SubElement(loop, role, {"link": name})


def move_base(rng, tree):
    """The whole linkage elsewhere: a new base, with the old one fixed to it."""
    carried = {side.get("link") for side in tree.iter("child")}
    roots = [link.get("name", "") for link in tree.findall("link")]
    roots = [name for name in roots if name not in carried]
    if roots:
        tree.insert(0, ElementTree.Element("link", {"name": "world0"}))
        joint = ElementTree.SubElement(tree, "joint", {"name": "stand", "type": "fixed"})
        rpy = rng.choice(("0 0 0", "0.3 -0.2 1.1", "3 1.5707963267948966 0", "1.57 0 0"))
        ElementTree.SubElement(joint, "origin", {"xyz": "0.3 -2 1", "rpy": rpy})
        ElementTree.SubElement(joint, "parent", {"link": "world0"})
        ElementTree.SubElement(joint, "child", {"link": roots[0]})


def unphysical(rng, tree):
    item = _some(rng, tree, "mass", "inertia")
    if item is not None:
        name = rng.choice(sorted(item.attrib) or ["value"])
        item.set(name, rng.choice(("-1", "-0.2", "0", "100", "1e-12")))


def foreign(rng, tree):
    item = _some(rng, tree)
    item.insert(0, ElementTree.fromstring(rng.choice(FOREIGN)))


def prefix(rng, tree):
    """An element in a namespace of its own: to XML, it is another element."""
    item, _ = _part(rng, tree)
    item.tag = f"{{{rng.choice(('u', 'http://ros.org/wiki/xacro', 'drake'))}}}{item.tag}"


def write_text(rng, tree):
    item = _some(rng, tree)
    item.text = rng.choice(("1 0 0", "stray", "<axis xyz='0 0 1'/>", "]]>", "${x}"))


ELEMENTS: tuple[Change, ...] = (
    drop_element, repeat_element, misspell_element, drop_attribute, misspell_attribute,
    change_number, change_number, odd_number, change_count, zero_vector, stretch_axis,
    turn_joint, random_axis, swap_ends, swap_links, reparent, retype, retype, nest, bury, lift,
    shuffle, shuffle, rename, rename, misname, mimic, pitch, independent, second_axis,
    add_frame, add_frame, add_loop, move_base, move_base, unphysical, unphysical, foreign,
    foreign, prefix, write_text,
)  # fmt: skip
