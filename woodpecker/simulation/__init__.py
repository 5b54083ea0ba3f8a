"""Simulations of the toy, returns to the section, and paths as smooth maps."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
