"""Regions of two parameters with the same cycles, by stability and period."""

from .census import Count as Count
from .census import SampledAttractor as SampledAttractor
from .census import Settles as Settles
from .regions import Region as Region
from .regions import Regions as Regions
from .regions import load_regions as load_regions
from .survey import Survey as Survey
from .verb import parameter_regions as parameter_regions
