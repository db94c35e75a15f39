from . import (
    bodies as bodies,
)
from . import (
    checks as checks,
)
from . import (
    flexible as flexible,
)
from . import (
    masses as masses,
)
from . import (
    momentum as momentum,
)
from . import (
    motion as motion,
)
from . import (
    pose as pose,
)
from . import (
    space as space,
)
from . import (
    studies as studies,
)
from .masses.counterweights.counterweights import counterweights as counterweights
from .masses.counterweights.counterweights_result import Counterweights as Counterweights
from .masses.designs.best_design import Design as Design
from .masses.designs.best_design import design as design
from .masses.identification.identification import Identification as Identification
from .masses.identification.identify import identify as identify
from .masses.mode_answers import ModeAnswers as ModeAnswers
from .masses.mode_answers import motion_modes as motion_modes
from .masses.partial_balance.budgets import pareto as pareto
from .masses.partial_balance.budgets import partial as partial
from .masses.partial_balance.partial_balance import (
    ParetoFront as ParetoFront,
)
from .masses.partial_balance.partial_balance import (
    PartialBalance as PartialBalance,
)
from .masses.remedies.compare import (
    RemedyComparison as RemedyComparison,
)
from .masses.remedies.compare import (
    compare_remedies as compare_remedies,
)
from .masses.springs.find_springs import springs as springs
from .masses.springs.spring_balance import SpringBalance as SpringBalance
from .motion.paths.path_search import find_paths as find_paths
from .motion.paths.path_to_pose import path_to_pose as path_to_pose
from .motion.paths.reactionless_paths import ReactionlessPaths as ReactionlessPaths
from .motion.quiet.quiet_motion import quiet_motion as quiet_motion
from .motion.quiet.quiet_motion_result import QuietMotion as QuietMotion
from .motion.quiet.quiet_timing import quiet_timing as quiet_timing
from .motion.verification.verification import Verification as Verification
from .motion.verification.verify_motions import verify as verify
from .space.certification.certified_space import CertifiedSpace as CertifiedSpace
from .space.certification.certify_space import certify as certify
from .space.formulas.derive import formulas as formulas
from .space.formulas.formula_data import Formulas as Formulas
from .space.interpretation.explain import Explanation as Explanation
from .space.interpretation.explain import explain as explain
from .space.requirements.require import require as require
from .space.requirements.required_space import RequiredSpace as RequiredSpace
from .space.spaces.compute_space import design_space as design_space
from .space.spaces.design_space import DesignSpace as DesignSpace
from .studies.sweeps.sweep import sweep as sweep
from .studies.sweeps.sweep_table import SweepTable as SweepTable
from .studies.synthesis.mechanism import Synthesis as Synthesis
from .studies.synthesis.synthesize import synthesize as synthesize
from .support.linkages import load as load

__version__: str
