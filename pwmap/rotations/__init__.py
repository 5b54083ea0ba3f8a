"""Cycles by their words: rotation numbers, tongues, word families and organising centres."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
