"""How far the paper's toy is from the end of its stable motion, in percent of its parameters.

    python -m studies.robustness [--fast] [--out DIR]

It finds the smallest change of all parameters together by which the motion vanishes or becomes
unstable, and how far each parameter alone can be changed.
"""

from __future__ import annotations

import math
from pathlib import Path

from studies.common.clocks import timed
from studies.common.motion import GUESS
from studies.common.record import Results, command
from woodpecker import Toy, shoot
from woodpecker.robustness import Limit, SmallestChange, smallest_changes

FEW = ("eps_n1", "mu_2")


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Find the smallest changes that end the motion.

    Parameters
    ----------
    fast
        Two parameters only.
    out
        Not used: there is no picture.

    Returns
    -------
    dict
        Seconds; of each change effect, cause, size in percent, the changes, the angle between
        change and gradient, and what shooting says on both sides; of each parameter alone the
        changes down and up at which the motion ends, None if it does not, and what ends it.
    """
    toy = Toy()
    motion = shoot(toy, GUESS)
    found, clock = timed(lambda: smallest_changes(toy, motion, FEW if fast else None))
    return {
        "seconds": clock.wall,
        "critical": [_about(each) for each in (*found.critical, *found.harmless)],
        "limits": [_alone(each) for each in found.limits],
    }


def _about(each: SmallestChange) -> Results:
    return {
        "effect": each.effect.value, "kind": each.kind, "cause": each.cause,
        "percent": 100.0 * each.size, "changes": dict(each.changes), "stable": each.stable,
        "angle": None if math.isnan(each.angle) else each.angle,
        "confirmed": each.confirmed, "evidence": each.evidence,
    }  # fmt: skip


def _alone(each: Limit) -> Results:
    ends = math.isfinite(each.percent)
    return {
        "parameter": each.parameter, "direction": each.direction,
        "percent": each.percent if ends else None, "kind": each.kind, "cause": each.cause,
    }  # fmt: skip


if __name__ == "__main__":
    command(main, "robustness")
