"""A map of the line at one parameter: its borders, jumps and cycles, and where orbits settle."""

from .attracting import OrbitDiagram as OrbitDiagram
from .attracting import SettledOrbit as SettledOrbit
from .attracting import Swept as Swept
from .attracting import SweptMap as SweptMap
from .attracting import unexplained as unexplained
from .borders import Border as Border
from .borders import BorderKind as BorderKind
from .jumps import Jump as Jump
from .local import LocalModel as LocalModel
from .local import Start as Start
from .local import local_model as local_model
from .orbits import Orbit as Orbit
from .slices import Slice as Slice
from .slices import slices_at as slices_at
from .windows import borders_in as borders_in
from .windows import crosses as crosses
from .windows import nearest_border as nearest_border
