"""Whether orbits lie inside their pieces."""

from __future__ import annotations

from woodpecker.slices.orbits import Condition, Margin, Orbit


def is_inside(orbit: Orbit, closing: Condition) -> bool:
    """Whether all margins are positive, but for the one at the end of a border orbit."""
    for i, image in enumerate(orbit.images):
        own = closing.code if isinstance(closing, Margin) and closing.index == i else -1
        if ((image.margins < 0.0) & (image.causes != own)).any():
            return False
    return True
