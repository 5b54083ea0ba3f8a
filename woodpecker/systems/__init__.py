"""Any mechanical system with contacts and friction: motions, exact return maps, continuation.

Names are loaded when they are first used; ``__init__.pyi`` says where each one is defined.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
