"""Exact analysis of piecewise-linear discontinuous maps; diagrams and their graphs.

A name is loaded, with what it needs, when it is first used; ``__init__.pyi`` says where each is.
Specialised names are in subpackages such as :mod:`pwmap.longrun` or :mod:`pwmap.plane`.
"""

import warnings
from importlib import import_module

import lazy_loader

_attached, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


_RENAMED = {"Jump": "Discontinuity", "Piece": "LinearPiece"}


def __getattr__(name: str) -> object:
    """A public name; for one release old ones, too, and those that have moved into a room."""
    if name in _RENAMED:
        text = f"pwmap.{name} is deprecated: it is pwmap.{_RENAMED[name]} now"
        warnings.warn(text, DeprecationWarning, stacklevel=2)
        return _attached(_RENAMED[name])
    for room in () if name in __all__ or name.startswith("_") else _ROOMS:
        module = import_module(f"{__name__}.{room}")
        if name in module.__all__:
            text = f"pwmap.{name} has moved: use pwmap.{room}.{name}"
            warnings.warn(text, DeprecationWarning, stacklevel=2)
            return getattr(module, name)
    return _attached(name)


_ROOMS = ("diagrams", "longrun", "maps", "plane", "proofs", "rotations")
