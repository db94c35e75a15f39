from .closure.assembly.tool_frame import tool as tool
from .closure.taylor.many_poses import (
    ManyTaylorMotions as ManyTaylorMotions,
)
from .closure.taylor.many_poses import (
    taylor_motion_many as taylor_motion_many,
)
from .closure.taylor.taylor_motion import (
    TaylorMotion as TaylorMotion,
)
from .closure.taylor.taylor_motion import (
    taylor_motion as taylor_motion,
)
from .loading.building.dh_rows import from_dh as from_dh
from .loading.building.from_pinocchio import from_pinocchio as from_pinocchio
from .loading.building.screw_joints import ScrewJoint as ScrewJoint
from .loading.building.screw_joints import from_screws as from_screws
from .loading.model_gallery import gallery as gallery
from .loading.model_gallery import load as load
from .model.linkage import (
    Body as Body,
)
from .model.linkage import (
    Joint as Joint,
)
from .model.linkage import (
    Linkage as Linkage,
)
from .model.linkage import (
    Loop as Loop,
)
from .model.linkage import (
    Notice as Notice,
)
from .model.motion import Motion as Motion
from .numerics.compiled.background import compile as compile

__version__: str
