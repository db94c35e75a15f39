"""Many linkages: from sketches, sweeps, searches for special geometries, synthesis.

Names for users, beside those of `balance` itself:

- ``Study``: a model, what varies in it, what must hold, and what is computed
- ``read_study``: read what varies and what is computed from a TOML file
- ``FourBarPlatform``: sizes of ``four_bar_platform_urdf``
- ``PantographMasses``: lengths and masses of a pantograph
- ``ParallelepipedPlatform``: sizes of ``parallelepiped_platform_urdf``
- ``PrincipalVectors``: points and masses of ``principal_vector_urdf``
- ``SketchedLinkage``: result of ``linkage_from_sketch``
- ``StackedFourBar``: one four-bar of ``four_bar_stack_urdf``
- ``StackedChains``: lengths and masses of ``stacked_urdf``
- ``SynthesizedMechanism``: one mechanism, its file and what confirms it
- ``equivalent_points``: four point masses that are equivalent to a rigid body
- ``four_bar_platform_urdf``: write a platform on three legs of balanced four-bars, balanced
- ``four_bar_stack_urdf``: write balanced four-bars that stand on each other, n freedoms
- ``linkage_from_sketch``: build a planar linkage from its points and links, and its file
- ``parallelepiped_platform_urdf``: write a spatial platform of three or six freedoms, balanced
- ``principal_points``: principal points of elements in series from their masses
- ``principal_vector_urdf``: write a principal-vector linkage of n elements, balanced
- ``stacked_urdf``: write two balanced chains stacked into a mechanism of two freedoms
"""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
