"""The least shaking for a budget of matter as a quantity of a sweep, as ``balance reduce`` has it.

Options and defaults are those of `balance.partial`; the motions are the turn of a crank, or one
between poses, and without either the random ones.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from balance.masses.partial.budgets import CHEAPEST_ORDER, partial
from balance.masses.partial.results import PartialBalance
from balance.masses.partial.shaking_problem import (
    RANDOM_MOTIONS,
    SAMPLES,
    ShakingOptions,
    build_problem,
)
from balance.motion.verification.trajectory import random_motions
from balance.space.spaces.compute_space import design_space
from balance.studies.runs.chunk_job import Column
from balance.studies.sweeps.geometry import SweptGeometry
from balance.studies.sweeps.swept_motion import MOTION_OPTIONS, motion_of_options
from kinematics.errors import UsageError
from kinematics.model.linkage import Linkage
