"""How far the parameters of a toy can change until its stable periodic motion ends."""

from .found import Effect as Effect
from .found import Limit as Limit
from .found import Robustness as Robustness
from .found import SmallestChange as SmallestChange
from .smallest import smallest_changes as smallest_changes
