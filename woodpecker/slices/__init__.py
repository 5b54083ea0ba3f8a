"""A map of the line at one parameter: its borders, jumps and cycles, and where orbits settle.

A slice lists all cycles and jump crossings of an iterate in a window.

Names are loaded, with what they need, at first use; ``__init__.pyi`` says where each is defined.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
