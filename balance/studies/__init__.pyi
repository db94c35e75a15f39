from .sketches.from_sketch import linkage_from_sketch as linkage_from_sketch
from .sketches.sketched_linkage import SketchedLinkage as SketchedLinkage
from .sweeps.study import Study as Study
from .sweeps.study import read_study as read_study
from .synthesis.four_bar_platform import FourBarPlatform as FourBarPlatform
from .synthesis.four_bar_platform import four_bar_platform_urdf as four_bar_platform_urdf
from .synthesis.four_bar_stack import StackedFourBar as StackedFourBar
from .synthesis.four_bar_stack import four_bar_stack_urdf as four_bar_stack_urdf
from .synthesis.mechanism import SynthesizedMechanism as SynthesizedMechanism
from .synthesis.pantograph import PantographMasses as PantographMasses
from .synthesis.parallelepiped_platform import (
    ParallelepipedPlatform as ParallelepipedPlatform,
)
from .synthesis.parallelepiped_platform import equivalent_points as equivalent_points
from .synthesis.parallelepiped_platform import (
    parallelepiped_platform_urdf as parallelepiped_platform_urdf,
)
from .synthesis.principal_vectors import PrincipalVectors as PrincipalVectors
from .synthesis.principal_vectors import principal_points as principal_points
from .synthesis.principal_vectors import principal_vector_urdf as principal_vector_urdf
from .synthesis.sarrus_stack import StackedChains as StackedChains
from .synthesis.sarrus_stack import stacked_urdf as stacked_urdf
