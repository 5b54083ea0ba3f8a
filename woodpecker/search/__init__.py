"""The search for all branches of a map: from slices, along branches, to their ends.

A caller meets these where a search is watched, interrupted or judged; it is started by
:func:`woodpecker.bifurcation_diagram` or :func:`woodpecker.continuation`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
