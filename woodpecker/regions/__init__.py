"""Regions of two parameters in which the same cycles live.

Cycles are counted at many places; where two of these disagree a curve lies between them, which is
found and followed.

A name is loaded with what it needs when it is first used; ``__init__.pyi`` says where each is.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
