"""The amount of work that the study of reductions measures."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """How much is measured."""

    rounds: int = 9
    starts: int = 400  # of the map, for phases and impacts
    impacts: int = 400
    edges: int = 100  # starts between which changes of word are looked for
    densities: tuple[int, ...] = (4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096)


FAST = Plan(rounds=3, starts=40, impacts=60, edges=20, densities=(4, 64, 1024))
