"""The toy: its data, its equations of motion, and what is known in closed form.

[Leine2001, Eqs. 1-11]; what the paper misprints or leaves out is said where it is corrected.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
