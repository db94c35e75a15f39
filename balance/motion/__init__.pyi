from .floating_base.base import FloatingBase as FloatingBase
from .floating_base.result import FloatingBaseMotion as FloatingBaseMotion
from .floating_base.simulate import simulate_floating_base as simulate_floating_base
from .paths.path import ReactionlessPath as ReactionlessPath
from .paths.path import timed_path as timed_path
from .verification.shaking_wrench import shaking as shaking
from .verification.trajectory import Trajectory as Trajectory
