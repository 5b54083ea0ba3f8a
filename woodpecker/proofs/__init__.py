"""Proofs in ball arithmetic of what a computation has found; they need the extra ``proof``.

A proof is a certificate, which other code with other arithmetic checks.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
