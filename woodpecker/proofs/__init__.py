"""Proofs of computed orbits, branches and points in ball arithmetic; needs the extra ``proof``."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
