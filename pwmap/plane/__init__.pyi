"""A plane of two parameters, cut by exact curves."""

from .colours import Colours as Colours
from .crisiscurves import with_crises as with_crises
from .curves import CodimensionTwo as CodimensionTwo
from .curves import PlaneCurve as PlaneCurve
from .kinds import PlaneKind as PlaneKind
from .network import parameter_plane as parameter_plane
from .plane import ParameterPlane as ParameterPlane
from .plane import PlaneRegion as PlaneRegion
from .plane import load_plane as load_plane
from .rasters import PlaneRaster as PlaneRaster
from .rasters import load_raster as load_raster
from .rasters import plane_raster as plane_raster
from .strips import Strip as Strip
