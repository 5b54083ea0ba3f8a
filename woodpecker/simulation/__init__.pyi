"""Simulations of the toy, its returns to the section, and its paths as smooth maps."""

from .returns import Return as Return
from .returns import ReturnMap as ReturnMap
from .returns import first_return as first_return
from .status import Status as Status
from .trajectory import EnergyBalance as EnergyBalance
from .trajectory import Event as Event
from .trajectory import Impulse as Impulse
from .trajectory import State as State
from .trajectory import Trajectory as Trajectory
from .trajectory import energy_balance as energy_balance
from .trajectory import simulate as simulate
from .words import EventKind as EventKind
