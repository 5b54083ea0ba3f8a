"""Pictures are in :mod:`pwmap.plot`: this name of the file is there for one release."""

import warnings

from pwmap.plot import plot_plane as plot_plane

warnings.warn("pwmap.plot_plane has moved: use pwmap.plot", DeprecationWarning, stacklevel=2)
