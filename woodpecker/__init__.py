"""The Woodpecker Toy: exact events, return map, periodic solutions and their bifurcations.

Here are the main functions, with the types that they take and return; more is in subpackages such
as ``woodpecker.plane`` and ``woodpecker.proofs``. Names are loaded, with what they need, at first
use; the ``__init__.pyi`` of each package says where each is defined.
"""

import warnings
from importlib import import_module
from typing import Any

import lazy_loader

_of_stub, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

# Names that were at the top, by the module that has them now; removed after the next release.
_MOVED = {
    "branches": "OnBranch",
    "maps": "BoundedPiece Image Iterate Piece Sweep check_derivatives",
    "mechanics": "Equilibrium energy free_frequency",
    "plane": "Family PlaneKind PlanePoint PlaneStretch SymbolicFamily ToyFamily "
    "family_from_pwmap family_from_sympy graph_of_curves",
    "regions": "Count Region Regions Settles Survey parameter_regions",
    "robustness": "Effect Limit Robustness",
    "search": "BranchState Found Record Seen Stage",
    "simulation": "EnergyBalance Impulse energy_balance",
    "slices": "Border BorderKind Jump LocalModel Orbit SettledOrbit Slice Start Swept SweptMap "
    "borders_in crosses nearest_border unexplained",
}
_PLACES = {
    **{name: f"{place}.{name}" for place, names in _MOVED.items() for name in names.split()},
    "Attractor": "regions.SampledAttractor",
    "Trouble": "robustness.SmallestChange",
    "Undecided": "proofs.NotProved",
    "find_all": "diagrams.bifurcation_search",
}
_GONE = {  # functions that another one replaces: where each still is, and what to call instead
    "connected": ("search.diagrams", "continuation(map_, shoot(map_, x, p=p), settings=settings)"),
    "cycle_near": ("search.diagrams", "shoot(map_, x, p=p)"),
    "curve_through": (
        "plane.following",
        "curve_in_two(family, point, family.names, span, value=other, settings=settings)",
    ),
    "regions_of": (
        "regions.verb",
        "regions.parameter_regions(family, family.names, span, curves=curves, settings=settings)",
    ),
    "whole_diagram": ("search.diagrams", "bifurcation_diagram(map_, settings=settings)"),
}


def __getattr__(name: str) -> Any:
    """The object of a name in the stub, or of a moved one, with a warning that says where it is."""
    if name in _GONE:
        place, call = _GONE[name][0] + f".{name}", f"call woodpecker.{_GONE[name][1]}"
    elif name in _PLACES:
        place = _PLACES[name]
        call = f"it is woodpecker.{place} now"
    else:
        return _of_stub(name)
    warnings.warn(f"woodpecker.{name} is deprecated: {call}", DeprecationWarning, stacklevel=2)
    module, _, own = place.rpartition(".")
    return getattr(import_module(f"{__name__}.{module}"), own)
