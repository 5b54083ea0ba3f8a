"""The toy: data, equations of motion [Leine2001, Eqs. 1-11], contact problems, closed forms.

Misprints and gaps of the paper are noted where they are corrected.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
