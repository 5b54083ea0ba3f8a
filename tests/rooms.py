"""The rooms of both packages: folders with public names, not all of which are at the top."""

from importlib import import_module

import pwmap
import woodpecker

NAMES = {
    pwmap: ("diagrams", "longrun", "maps", "plane", "proofs", "rotations"),
    woodpecker: (
        *("maps", "mechanics", "plane", "proofs", "regions", "robustness"),
        *("search", "simulation", "slices"),
    ),
}
ROOMS = {
    package: [import_module(f"{package.__name__}.{name}") for name in names]
    for package, names in NAMES.items()
}
ALL = [room for each in ROOMS.values() for room in each]
