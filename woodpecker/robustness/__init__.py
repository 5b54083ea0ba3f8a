"""How far the parameters of a toy can change until its stable periodic motion ends.

:func:`smallest_changes` follows the motion along straight lines in the space of parameters to the
nearest fold, flip, border collision or loss, for each parameter alone and for all together.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
