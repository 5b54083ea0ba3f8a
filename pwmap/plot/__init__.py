"""Pictures of maps, diagrams, long runs and planes of parameters, with matplotlib.

Every function takes the axes to draw on, or makes some, and gives a :class:`Drawn`: the artists by
name. A name is loaded with what it needs when it is first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
