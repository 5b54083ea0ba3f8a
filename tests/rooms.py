"""The rooms of woodpecker: folders whose names are public there, and not at the top."""

from importlib import import_module

NAMES = (
    *("maps", "mechanics", "plane", "proofs", "regions", "robustness"),
    *("search", "simulation", "slices"),
)  # fmt: skip
ROOMS = [import_module(f"woodpecker.{name}") for name in NAMES]
