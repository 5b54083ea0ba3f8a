"""Maps as words, pieces and cylinders; what a computation may take."""

from .budget import Advance as Advance
from .budget import Meter as Meter
from .budget import Progress as Progress
