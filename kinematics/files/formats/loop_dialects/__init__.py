"""Loops of a URDF file in the words of other tools, translated to elements of URDF with loops.

One module per dialect finds its elements and adds to a `draft.Draft` what they say: a
``<loop>``, a ``<mimic>``, a fixed joint or a remark. What does not say enough is refused with
the ``<loop>`` to write; `unread_closures` tells of elements that no module knows.
"""
