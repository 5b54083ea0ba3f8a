"""Maps of the line, made of smooth pieces: from formulas of your own, from sympy and from pwmap.

At each point a map tells which piece it takes, with the value, its derivatives, and the margins:
functions that are positive inside of the piece, of which one vanishes at its border. Any object
with a method ``at(x, p)`` that returns an :class:`Image` is a map.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
