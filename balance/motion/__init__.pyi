from .floating_base.base import FloatingBase as FloatingBase
from .floating_base.floating_base_motion import FloatingBaseMotion as FloatingBaseMotion
from .floating_base.simulate import simulate_floating_base as simulate_floating_base
from .manufacture.analyse import ShakingTolerance as ShakingTolerance
from .manufacture.analyse import shaking_tolerance as shaking_tolerance
from .paths.inertia_ratios import InertiaChart as InertiaChart
from .paths.inertia_ratios import PathMoments as PathMoments
from .paths.inertia_ratios import inertia_chart as inertia_chart
from .paths.inertia_ratios import moments_through_poses as moments_through_poses
from .paths.path import ReactionlessPath as ReactionlessPath
from .paths.path import timed_path as timed_path
from .verification.comparison import (
    VerificationComparison as VerificationComparison,
)
from .verification.comparison import (
    verify_against as verify_against,
)
from .verification.crank_revolution import one_turn as one_turn
from .verification.given_motions import (
    from_csv as from_csv,
)
from .verification.given_motions import (
    rest_to_rest as rest_to_rest,
)
from .verification.holding_torques import holding_torques as holding_torques
from .verification.shaking_wrench import shaking as shaking
from .verification.tool_motion import from_tool_csv as from_tool_csv
from .verification.trajectory import Trajectory as Trajectory
