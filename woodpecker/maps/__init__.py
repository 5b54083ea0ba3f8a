"""Maps of the line, made of smooth pieces: formulas of your own, of sympy and of pwmap.

A map says at each point which piece it takes, with value, derivatives, and margins: functions that
are positive inside of the piece, and of which one vanishes at its border. Whatever has a method
``at(x, p)`` that returns an :class:`Image` is a map.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
