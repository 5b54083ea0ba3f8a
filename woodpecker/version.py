"""The version of the program: of the distribution that holds both packages."""

from pwmap.version import __version__

__all__ = ["__version__"]
