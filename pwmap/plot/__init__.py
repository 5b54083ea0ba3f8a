"""Pictures of maps, diagrams, long runs and planes of parameters, with matplotlib.

Every function draws on given axes or new ones, and returns them and its artists: a :class:`Drawn`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
