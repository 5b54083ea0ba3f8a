"""Any mechanical system with contacts and friction: motions, exact return maps, continuation."""

from .model import Contact as Contact
from .model import ContactSystem as ContactSystem
from .model import FrictionBound as FrictionBound
from .model import ImpactLaw as ImpactLaw
from .model import from_kane as from_kane
from .motion import Backend as Backend
from .motion import Event as Event
from .motion import MotionStatus as MotionStatus
from .returns import SystemMap as SystemMap
from .sections import Section as Section
from .verbs import Cycle as Cycle
from .verbs import CycleStatus as CycleStatus
from .verbs import Motion as Motion
from .verbs import SystemReturns as SystemReturns
from .verbs import continuation as continuation
from .verbs import return_map as return_map
from .verbs import shoot as shoot
from .verbs import simulate as simulate
