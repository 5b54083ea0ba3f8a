"""How far the parameters of a toy can be changed until its stable periodic motion ends.

:func:`smallest_changes` follows the motion along lines through the space of all parameters, and
finds the nearest fold, flip, border collision or loss, in each of them alone and in all together.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
