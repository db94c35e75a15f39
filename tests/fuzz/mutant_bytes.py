"""Changes of the bytes of a file, and of the lines of a YAML file."""

from __future__ import annotations


def cut(rng, data):
    return data[: rng.randrange(len(data) + 1)]


def cut_out(rng, data):
    i = rng.randrange(len(data) + 1)
    return data[:i] + data[i + rng.randrange(1, 60) :]


def insert(rng, data):
    i = rng.randrange(len(data) + 1)
    odd = (b"<", b">", b"&", b'"', b"\0", b"\xff", b"&#0;", b"&lol;", b"<!--", b"-->", b"\n",
        b"<![CDATA[", b"<?x?>", b"  ", "é".encode(), b"[", b"]", b"{", b"*", b": ")  # fmt: skip
    return data[:i] + rng.choice(odd) + data[i:]


def repeat_span(rng, data):
    i = rng.randrange(len(data) + 1)
    return data[:i] + data[i : i + rng.randrange(1, 200)] + data[i:]


def comment_out(rng, data):
    i, k = rng.randrange(len(data) + 1), rng.randrange(20, 400)
    return data[:i] + b"<!--" + data[i : i + k].replace(b"--", b"") + b"-->" + data[i + k :]


def quote(rng, data):
    """An element as character data, in which nobody looks for it."""
    i = data.find(b"<", rng.randrange(len(data) + 1))
    k = data.find(b"/>", i) + 2
    return data if i < 0 or k < 2 else data[:i] + b"<![CDATA[" + data[i:k] + b"]]>" + data[k:]


def line_ends(rng, data):
    return data.replace(b"\n", rng.choice((b"\r\n", b"\r", b"\n\n")))


def encode(rng, data):
    name = rng.choice(("utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-7"))
    return data.decode("utf-8", "replace").encode(name)


def declare(rng, data):
    names = (b"utf-8", b"UTF-16", b"iso-8859-1", b"klingon", b"utf-7", b"ascii")
    return b'<?xml version="1.0" encoding="' + rng.choice(names) + b'"?>' + data


def doctype(rng, data):
    return rng.choice((b"<!DOCTYPE robot>", b"<!DOCTYPE r [<!ENTITY a 'b'>]>")) + data


TEXTS = (
    cut,
    cut_out,
    insert,
    insert,
    repeat_span,
    comment_out,
    quote,
    line_ends,
    encode,
    declare,
    doctype,
)


def drop_line(rng, data):
    lines = data.splitlines(keepends=True)
    return b"".join(rng.sample(lines, len(lines))[1:])


def add_line(rng, data):
    return data + rng.choice(
        (
            b"colour: red\n",
            b"name_mot: u\n",
            b"name_mot: [u1, nowhere]\n",
            b"rotule_name: q\n",
            b"a: &a [*a]\n",
            b"type: !!python/name:os.system\n",
            b"---\n",
            b"type: 3d\n",
            b"Lidmot: [0]\n",
            b"closed_loop: []\n",
            b"name_closedloop: x\n",
            b"? [a]\n",
            b"joint_name: []\njoint_type: []\n",
            b"type: {a: b}\n",
            b"type: [3d]\n",
        )
    )


def change_word(rng, data):
    old = rng.choice((b"3d", b"6d", b"closed_loop", b"type", b"[", b"]", b",", b"_", b"s"))
    return data.replace(old, rng.choice((b"6D", b"", b"[", b"~", b"5d", b"type", b"x")), 1)


YAMLS = (drop_line, add_line, change_word)
