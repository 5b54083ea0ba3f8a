"""Proofs in ball arithmetic of what a computation has found; they need the extra ``proof``."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
