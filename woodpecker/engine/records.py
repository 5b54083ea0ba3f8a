"""Curves and their ends as a diagram keeps them: words, and how well ends are located."""

from __future__ import annotations

import math

import numpy as np

from pwmap.diagrams.diagram import BranchKind, PointKind, PointStatus, Stretch
from woodpecker.base.arrays import Floats
from woodpecker.engine.branches import Collision, Curve, End
from woodpecker.engine.orbits import Closed, jacobian, scales
from woodpecker.engine.settings import Settings
from woodpecker.engine.stepping import NEAR

ROUNDING = 20.0 * 2.0**-52  # relative: images and margins are those of points this far away, which
# is what a return of the toy loses over its events


def stretches(curve: Curve) -> tuple[Stretch, ...]:
    """Stretches of a curve with one word, each with the cause of the change that begins it.

    A sample at a border has the pieces of one side, and a jump there those of either; words that
    only such a sample has are passed over. What has no mark is the orbit of a limit of a jump that
    meets a border where borders accumulate.
    """
    causes = {mark.sample + 1: mark.cause for mark in curve.marks}
    ends = [word.first for word in curve.words[1:]] + [len(curve.parameter)]
    unmarked = OF_A_LIMIT if curve.kind is BranchKind.JUMP else ""
    found: list[Stretch] = []
    for word, end in zip(curve.words, ends, strict=True):
        first = 0 if not found else word.first
        at_border = end == word.first + 1 < len(curve.parameter) and (end in causes or end == 1)
        if at_border or (found and found[-1].word == word.text):
            continue
        cause = causes.get(first) or causes.get(first + 1) or unmarked
        found.append(Stretch(first, word.text, cause if found else ""))
    return tuple(found)


OF_A_LIMIT = "the orbit of a limit of the jump meets a border"


def precision(end: End, curve: Curve, k: int, settings: Settings) -> float:
    """How well the parameter of an end of a curve, its sample k, is located.

    At a flip by how far its multiplier is from -1, at a collision by what rounding of the map makes
    of its equations; at a fold an error of the orbit changes the parameter by its square only.
    """
    if end.status is PointStatus.OPEN:
        return math.inf
    if end.precision > 0.0:
        return end.precision
    least = settings.converged * settings.p_scale
    if end.collision is not None:
        return max(least, _blurred(end.collision, settings))
    if end.kind is PointKind.PD and len(curve.parameter) > 1:
        return max(least, _missed(curve, k))
    if end.kind is PointKind.BP:
        return NEAR * settings.max_step * settings.p_scale
    return 0.0 if end.p in settings.span else least


def _blurred(met: Collision, settings: Settings) -> float:
    """How far rounding of a map moves the parameter of a collision."""
    orbit, scale = met.orbit, scales(len(met.orbit), settings)
    conditions = (Closed(), met.margin)
    matrix = jacobian(orbit, conditions, scale)
    point = np.abs(orbit.point / scale)
    noise = ROUNDING * (np.abs(matrix) @ point)
    noise[: len(orbit)] += ROUNDING * settings.x_scale * point[:-1]
    try:
        back: Floats = np.linalg.inv(matrix)[-1]
    except np.linalg.LinAlgError:
        return math.inf
    return float(np.abs(back) @ noise) * settings.p_scale


def _missed(curve: Curve, k: int) -> float:
    """How far a flip lies from where the multiplier, on a straight line, is -1."""
    beside = 1 if k == 0 else k - 1
    rise = float(curve.multiplier[beside] - curve.multiplier[k])
    run = float(curve.parameter[beside] - curve.parameter[k])
    return abs((curve.multiplier[k] + 1.0) * run / rise) if rise else 0.0
