"""Regions of two parameters in which the same cycles live.

Cycles are counted at many places; where two of these disagree a curve lies between them, which is
found and followed.

A name is loaded with what it needs when it is first used; ``__init__.pyi`` says where each is.
"""

import warnings
from typing import Any

import lazy_loader

_of_stub, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """A name of the stub; the old one of an attractor with a DeprecationWarning."""
    if name == "Attractor":
        name = "SampledAttractor"
        warnings.warn(f"woodpecker.regions.Attractor is {name} now", DeprecationWarning, 2)
    return _of_stub(name)
