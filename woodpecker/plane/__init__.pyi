"""Two parameters: curves of special points, and families of maps."""

from .curve import Curve as Curve
from .curve import PlaneKind as PlaneKind
from .curve import PlanePoint as PlanePoint
from .curve import PlaneStretch as PlaneStretch
from .curve import load_curve as load_curve
from .families import Family as Family
from .families import SymbolicFamily as SymbolicFamily
from .families import family_from_pwmap as family_from_pwmap
from .families import family_from_sympy as family_from_sympy
from .graph import graph_of_curves as graph_of_curves
from .toys import ToyFamily as ToyFamily
