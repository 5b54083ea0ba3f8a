"""Regions of two parameters with the same cycles, by stability and period.

Cycles are counted at many places; between two places with different counts lies a curve of special
points, which is found and followed.
"""

import warnings
from importlib import import_module
from typing import Any

import lazy_loader

_of_stub, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """A public name of ``__init__.pyi``; former names with a DeprecationWarning."""
    if name == "Attractor":
        name = "SampledAttractor"
        warnings.warn(f"woodpecker.regions.Attractor is {name} now", DeprecationWarning, 2)
    if name == "regions_of":
        call = "parameter_regions(family, family.names, span, curves=curves, settings=settings)"
        warnings.warn(f"woodpecker.regions.regions_of: call {call}", DeprecationWarning, 2)
        return import_module("woodpecker.regions.verb").regions_of
    return _of_stub(name)
