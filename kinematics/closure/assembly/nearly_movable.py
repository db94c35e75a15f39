"""Loops at rest as written that would move with axes a little further away than rounding.

Three cranks of one length are a linkage, and a rigid frame where one is slightly longer. Files
with few decimals, or whose frames were measured, write the frame and mean the linkage.
"""

from __future__ import annotations

import numpy as np

from kinematics.closure.assembly.fit_axes import fit_axes
from kinematics.closure.mobility.components import split_components
from kinematics.closure.mobility.first_order import loop_singular_values
from kinematics.closure.series import loop_matrix
from kinematics.model.linkage import Linkage, Notice
from kinematics.numerics.tolerances import AXIS_ROUNDING, MAX_TRIED_AXIS_CHANGE
from kinematics.wording import count_noun, first_names


def note_nearly_movable(linkage: Linkage) -> list[Notice]:
    """Make a notice for each component with joints at rest that slightly other axes would free.

    Args:
        linkage: a linkage with its loops closed.
    """
    notices = []
    for part in split_components(linkage):
        names = [linkage.joints[j].name for j in part.joints]
        values, _ = loop_singular_values(loop_matrix(part.chain))
        resting = [name for name in names if name in linkage.idle]
        small = values < MAX_TRIED_AXIS_CHANGE * values.max(initial=0.0)
        free = sum(name in linkage.inputs for name in names)
        if not resting or np.sum(small) <= free:
            continue
        fit = fit_axes(part.draft)
        if fit is None or not AXIS_ROUNDING < fit.change <= MAX_TRIED_AXIS_CHANGE:
            continue
        if fit.freedom <= free:
            continue
        more = count_noun(fit.freedom - free, "degree")
        notices.append(
            Notice(
                "nearly_movable",
                (
                    f"{first_names(resting)} do not move as written; with axes moved by "
                    f"{fit.change:.0e} (radians, parts of the size of their loops) these have "
                    f"{more} of freedom more (--as-written for the answer without doubt)"
                ),
            )
        )
    return notices
