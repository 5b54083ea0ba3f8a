"""Any mechanical system with contacts and friction: motions, exact return maps, continuation."""

from .diagrams import LineOfSystem as LineOfSystem
from .diagrams import SettledReturns as SettledReturns
from .diagrams import basins as basins
from .diagrams import bifurcation_diagram as bifurcation_diagram
from .diagrams import curve_in_two as curve_in_two
from .diagrams import orbit_diagram as orbit_diagram
from .mechanics.model import Contact as Contact
from .mechanics.model import ContactSystem as ContactSystem
from .mechanics.model import FrictionBound as FrictionBound
from .mechanics.model import ImpactLaw as ImpactLaw
from .mechanics.model import from_kane as from_kane
from .mechanics.status import MotionStatus as MotionStatus
from .returns import SystemMap as SystemMap
from .simulation.motion import Backend as Backend
from .simulation.motion import MotionEvent as MotionEvent
from .simulation.sections import Section as Section
from .verbs import CycleStatus as CycleStatus
from .verbs import Motion as Motion
from .verbs import SystemCycle as SystemCycle
from .verbs import SystemReturns as SystemReturns
from .verbs import continuation as continuation
from .verbs import return_map as return_map
from .verbs import shoot as shoot
from .verbs import simulate as simulate
