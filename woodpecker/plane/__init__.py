"""Two parameters: curves of special points, and families of maps.

A family is a map with two parameters, either of which may vary while the other one is held. Curves
of the toy and of families are followed by :func:`woodpecker.curve_in_two`.

Names are loaded, with what they need, at first use; ``__init__.pyi`` says where each is defined.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
