"""Maps as words, pieces and cylinders; budgets of computations."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
