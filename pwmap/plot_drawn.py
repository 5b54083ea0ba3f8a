"""Pictures are in :mod:`pwmap.plot`: this name of the file is there for one release."""

import warnings

from pwmap.plot import Drawn as Drawn

warnings.warn("pwmap.plot_drawn has moved: use pwmap.plot", DeprecationWarning, stacklevel=2)
