from .counterweights.movable_weights import MovableWeight as MovableWeight
from .counterweights.movable_weights import MovableWeights as MovableWeights
from .counterweights.movable_weights import movable_weights as movable_weights
from .counterweights.parts.part_files import part_files as part_files
from .counterweights.parts.part_files import parts_of as parts_of
from .counterweights.regions import Region as Region
from .designs.feasibility import Feasibility as Feasibility
from .designs.feasibility import feasible as feasible
from .identification.exciting_motion import ExcitingMotion as ExcitingMotion
from .identification.exciting_motion import exciting_motion as exciting_motion
from .mode_answers import ModeAnswer as ModeAnswer
from .partial_balance.elastic_frame import ElasticFrame as ElasticFrame
from .partial_balance.least_violation import LeastViolation as LeastViolation
from .partial_balance.least_violation import least_violation as least_violation
from .payload import Payload as Payload
from .payload import carrying as carrying
from .payload import read_payload as read_payload
from .pure_inertias.buildable_masses import (
    BuildableMasses as BuildableMasses,
)
from .pure_inertias.buildable_masses import (
    buildable_masses as buildable_masses,
)
from .pure_inertias.pure_inertia import (
    PureInertia as PureInertia,
)
from .pure_inertias.pure_inertia import (
    pure_inertia as pure_inertia,
)
from .remedies.applied import AppliedRemedy as AppliedRemedy
from .remedies.counter_rotations.fewest_rotors import (
    FewestRotors as FewestRotors,
)
from .remedies.counter_rotations.fewest_rotors import (
    RotorSet as RotorSet,
)
from .remedies.counter_rotations.fewest_rotors import (
    fewest_rotors as fewest_rotors,
)
