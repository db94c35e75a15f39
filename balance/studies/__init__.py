"""Many linkages: sweeps, searches for special geometries, synthesis.

Names for users, beside those of `balance` itself:

- ``Study``: a model, what varies in it, what must hold, and what is computed
- ``read_study``: read what varies and what is computed from a TOML file
- ``PantographMasses``: lengths and masses of a pantograph
- ``SynthesizedMechanism``: one mechanism, its file and what confirms it
"""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
