from .decoupled.decoupling import Decoupling as Decoupling
from .decoupled.decoupling import decoupling as decoupling
from .decoupled.locked_inertia import locked_inertia as locked_inertia
from .interpretation.freedoms import Freedom as Freedom
from .many.many_geometries import ManySpaces as ManySpaces
from .many.many_geometries import design_space_many as design_space_many
from .spaces.distance_to_rank_drop import distance_to_rank_drop as distance_to_rank_drop
from .spaces.save import (
    SpaceRecord as SpaceRecord,
)
from .spaces.save import (
    load_space as load_space,
)
from .spaces.save import (
    save_space as save_space,
)
from .transfers.by_joint import Transfer as Transfer
