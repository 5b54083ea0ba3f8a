"""Pictures of maps, diagrams, long runs and planes of parameters, with matplotlib."""

from .diagrams import GREY as GREY
from .diagrams import INK as INK
from .diagrams import JUMP as JUMP
from .diagrams import MARKERS as MARKERS
from .diagrams import STABLE as STABLE
from .diagrams import STAR as STAR
from .diagrams import UNSTABLE as UNSTABLE
from .diagrams import VIOLET as VIOLET
from .diagrams import WIDTHS as WIDTHS
from .diagrams import axis_label as axis_label
from .diagrams import place_legend as place_legend
from .diagrams import plot_cobweb as plot_cobweb
from .diagrams import plot_diagram as plot_diagram
from .diagrams import plot_map as plot_map
from .drawn import Drawn as Drawn
from .longrun import plot_attractors as plot_attractors
from .longrun import plot_density as plot_density
from .longrun import plot_entropy as plot_entropy
from .longrun import plot_kneading as plot_kneading
from .longrun import plot_long_run as plot_long_run
from .plane import plot_plane as plot_plane
