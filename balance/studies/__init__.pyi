from .sweeps.study import Study as Study
from .sweeps.study import read_study as read_study
from .synthesis.mechanism import SynthesizedMechanism as SynthesizedMechanism
from .synthesis.pantograph import PantographMasses as PantographMasses
from .synthesis.principal_vectors import PrincipalVectors as PrincipalVectors
from .synthesis.principal_vectors import principal_vector_urdf as principal_vector_urdf
from .synthesis.stacking import StackedChains as StackedChains
from .synthesis.stacking import stacked_urdf as stacked_urdf
