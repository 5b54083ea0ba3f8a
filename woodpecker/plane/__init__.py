"""Two parameters: curves of special points, and families of maps.

A family is a map with two parameters, any of which may vary while the other one is held. Curves of
the toy and of families are followed by :func:`woodpecker.curve_in_two`.

A name is loaded with what it needs when it is first used; ``__init__.pyi`` says where each is.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
