"""The version of the program: of the distribution that holds both packages."""

from importlib.metadata import PackageNotFoundError, version

__all__ = ["__version__"]

try:
    __version__ = version("woodpecker-toy")
except PackageNotFoundError:  # a folder of sources on the path that nobody installed
    __version__ = "unknown"
