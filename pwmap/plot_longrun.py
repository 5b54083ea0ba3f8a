"""Pictures are in :mod:`pwmap.plot`: this name of the file is there for one release."""

import warnings

from pwmap.plot import plot_attractors as plot_attractors
from pwmap.plot import plot_density as plot_density
from pwmap.plot import plot_entropy as plot_entropy
from pwmap.plot import plot_kneading as plot_kneading
from pwmap.plot import plot_long_run as plot_long_run

warnings.warn("pwmap.plot_longrun has moved: use pwmap.plot", DeprecationWarning, stacklevel=2)
