"""A map of the line at one parameter: its borders, jumps and cycles, and where orbits settle.

A slice lists all cycles and jump crossings of an iterate in a window.

A name is loaded with what it needs when it is first used; ``__init__.pyi`` says where each is.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
