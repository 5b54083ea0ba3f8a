"""Maps of the line, made of smooth pieces: formulas of your own, of sympy and of pwmap."""

from .derivatives import check_derivatives as check_derivatives
from .formulas import BoundedPiece as BoundedPiece
from .formulas import FormulaMap as FormulaMap
from .formulas import FormulaPiece as FormulaPiece
from .formulas import Smooth as Smooth
from .iterates import Iterate as Iterate
from .pieces import Image as Image
from .pieces import Piece as Piece
from .pieces import PiecewiseMap as PiecewiseMap
from .sweeps import Sweep as Sweep
from .symbolic import from_pwmap as from_pwmap
from .symbolic import from_sympy as from_sympy
