"""The motion of the toy, from event to event, and its returns to the section.

Between two events the motion is known in closed form, so there is no time step.

A name is loaded with what it needs when it is first used; ``__init__.pyi`` says where each is.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
