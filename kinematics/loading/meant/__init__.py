"""The geometry that a file means: the special one inside the intervals of its digits.

A number of a file stands for an interval, half a unit of its last digit each way. Where a
geometry with parallel or meeting axes, or with equal lengths around a loop of four joints, lies
inside all intervals, the file means that one: `digits` finds the intervals, `link_widths` those
of distances and angles on a link, `four_joint_loops` the relations that hold inside them, and
`exact_screws` makes rational screws that satisfy them. See docs/theory/digits.md.
"""
