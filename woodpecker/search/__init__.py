"""The search for all branches of a map: from slices, along branches, to their ends.

It is started by :func:`woodpecker.bifurcation_diagram` or :func:`woodpecker.continuation`; the
types here watch it, interrupt it, and say what it found.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
