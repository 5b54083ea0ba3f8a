"""Curves and their ends as a diagram keeps them: words, and how well ends are located."""

from __future__ import annotations

import math

from pwmap.diagrams.diagram import BranchKind, PointKind, PointStatus, Stretch
from woodpecker.base.settings import Settings
from woodpecker.search.curves import Curve
from woodpecker.search.ends import End

# Part of the largest step to which a branch point is located: there the equations are singular, and
# rounding moves an orbit by its root.
AT_BRANCH_POINT = 1e-6


def stretches(curve: Curve) -> tuple[Stretch, ...]:
    """Stretches of a curve with one word, each with the cause of the change that begins it.

    A sample at a border has the pieces before it. What has no mark is the orbit of a limit of a
    jump that meets a border where borders accumulate.
    """
    causes = {mark.sample + 1: mark.cause for mark in curve.marks}
    unmarked = OF_A_LIMIT if curve.kind is BranchKind.JUMP else ""
    found: list[Stretch] = []
    for word in curve.words:
        if not found:
            found.append(Stretch(0, word.text, ""))
        elif found[-1].word != word.text:
            found.append(Stretch(word.first, word.text, causes.get(word.first) or unmarked))
    return tuple(found)


OF_A_LIMIT = "the orbit of a limit of the jump meets a border"


def precision(end: End, curve: Curve, k: int, settings: Settings) -> float:
    """How well the parameter of an end of a curve, its sample k, is located.

    At a flip by how far its multiplier is from -1; at all else it is known by now, what rounding of
    the map makes of its equations.
    """
    if end.precision > 0.0:
        return end.precision
    if end.status is PointStatus.OPEN:
        return math.inf
    least = settings.rounded_p(end.p)
    if end.kind is PointKind.PD and len(curve.parameter) > 1:
        return max(least, _missed(curve, k))
    if end.kind is PointKind.BP:
        return AT_BRANCH_POINT * settings.max_step * settings.p_scale
    return 0.0 if end.p in settings.span else least


def _missed(curve: Curve, k: int) -> float:
    """How far a flip lies from where the multiplier, on a straight line, is -1; +1 if doubled."""
    flip = math.copysign(1.0, float(curve.multiplier[k]))
    beside = 1 if k == 0 else k - 1
    rise = float(curve.multiplier[beside] - curve.multiplier[k])
    run = float(curve.parameter[beside] - curve.parameter[k])
    return abs((curve.multiplier[k] - flip) * run / rise) if rise else 0.0
