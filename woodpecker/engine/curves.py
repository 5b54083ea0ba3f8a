"""Curves of orbits: problems with one unknown left free, predictor and corrector along them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import lru_cache

import numpy as np

from woodpecker.base.arrays import Floats, Ints, norm
from woodpecker.base.checks import interval, lengths
from woodpecker.base.settings import unit
from woodpecker.base.shown import shown
from woodpecker.engine.maps import SpaceImage, SpaceMap, length_of, margins_decide, taken
from woodpecker.engine.newton import (
    MAP_ROUNDING,
    STEEP,
    Problem,
    across,
    cycles,
    solve,
    tangent,
    uncertainty,
)
from woodpecker.engine.orbits import (
    Chained,
    Condition,
    Held,
    OnBorder,
    SpaceOrbit,
    completed,
    head_of,
    pulled_inside,
)

SAME_END = 1e-6  # scaled: a refined end that lies farther from the first one is another point
SAME_VALUE = 1e-9  # scaled, relative to slopes: values of a piece that differ by more come
# from two solutions of its event times, as there are beside a grazing
SHORTEST_ROW = 1e-7  # a gradient shorter than this does not tell the distance of its border
LEVEL = 1e-7  # of a unit tangent: a smaller component along the parameter is noise


class Stop(Enum):
    """What ends an arc; the value is the sentence that a user reads."""

    SPAN = "end of the parameter span"
    WINDOW = "end of the window"
    BORDER = "a margin vanishes"
    SHARE = "a limit of the jump meets the diagonal"
    LP = "the branch turns round"
    PD = "the multiplier is -1"
    NS = "a pair of multipliers lies on the unit circle"
    BP = "another branch crosses"
    SPECIAL = "a test function of the curve's own vanishes"
    CLOSED = "the branch closes"
    OTHER_PIECE = "the map takes another piece"
    SHORT = "steps become too short"
    MANY = "as many samples as allowed"
    SPENT = "as many evaluations as allowed"
    ASKED = "stopped as asked"

    @property
    def is_open(self) -> bool:
        """Whether the curve was given up here, so that its continuation is unknown."""
        return self in (Stop.OTHER_PIECE, Stop.SHORT, Stop.MANY, Stop.SPENT)


MULTIPLIERS = (Stop.BP, Stop.LP, Stop.PD, Stop.NS)


@dataclass(frozen=True, slots=True, kw_only=True)
class CurveSettings:
    """How curves are followed, in scaled unknowns, and where they end.

    Parameters
    ----------
    spans
        Lower and upper end of each free parameter.
    window
        (d, 2) lower and upper end of each coordinate.
    step, min_step, max_step
        The first, the shortest and the longest step.
    max_turn
        The largest angle between consecutive tangents [rad].
    max_samples
        On an arc; all curves connected with a cycle may have twenty times as many.

    Raises
    ------
    ValueError
        If an interval is empty, or the steps do not ascend.
    """

    spans: tuple[tuple[float, float], ...]
    window: tuple[tuple[float, float], ...]
    step: float = 0.005
    min_step: float = 1e-9
    max_step: float = 0.02
    max_turn: float = 0.2
    max_samples: int = 5000

    def __post_init__(self) -> None:
        for name in ("spans", "window"):
            given = getattr(self, name)
            if not np.iterable(given) or any(map(np.isscalar, given)):
                raise ValueError(f"{name} must be pairs of two ends each, got {shown(given)}")
            object.__setattr__(self, name, tuple(interval(name, each) for each in given))
        if not 0.0 < self.min_step <= self.step <= self.max_step:
            raise ValueError(
                "expected 0 < min_step <= step <= max_step, got "
                f"{self.min_step}, {self.step}, {self.max_step}"
            )

    def cycles(
        self, free: Sequence[int], k: int, x_scale: Sequence[float] | None,
        p_scale: Sequence[float] | None,
    ) -> Problem:  # fmt: skip
        """The problem of cycles in some of k parameters; ValueError for wrong lengths.

        Lengths that count as 1 default to the window and the spans, and to 1 for held parameters.
        """
        ends = dict(zip(free, self.spans, strict=True))
        p_units = [unit(*ends[each]) if each in ends else 1.0 for each in range(k)]
        x_scale = lengths("x_scale", x_scale, [unit(*each) for each in self.window])
        return cycles(free, x_scale, lengths("p_scale", p_scale, p_units))

    def check_holds(self, p: Floats, x: Floats) -> None:
        """Raise ValueError if a cycle (n, d) or its free parameters p lie outside the limits."""
        parameter = "the parameter" if len(self.spans) == 1 else "a parameter"
        for name, at, (low, high) in (
            *((parameter, p[j : j + 1], span) for j, span in enumerate(self.spans)),
            *(("a coordinate", x[:, j], ends) for j, ends in enumerate(self.window)),
        ):
            if at.min() < low or at.max() > high:
                raise ValueError(
                    f"{name} of the cycle must lie in [{low}, {high}], got {at.tolist()}"
                )


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """An orbit on a curve, with the direction in which the curve is followed."""

    orbit: SpaceOrbit
    tangent: Floats  # unit vector in scaled unknowns
    # determinant of the equations bordered with the tangent; nan if unknown
    bordered: float = math.nan

    @property
    def rate(self) -> float:
        """The component of the tangent along the first free parameter."""
        return float(self.tangent[self.orbit.x.size])

    @property
    def ahead(self) -> float:
        """The same, but 0 if it is no more than noise."""
        return self.rate if abs(self.rate) > LEVEL else 0.0

    @property
    def turned(self) -> Sample:
        """The same sample of the curve followed in the other direction."""
        return Sample(self.orbit, -self.tangent, -self.bordered)


@dataclass(frozen=True, slots=True, eq=False)
class TestFunction:
    """A function along a curve; a change of its sign ends an arc."""

    stop: Stop  # what its zero means
    value: Callable[[Sample], float]
    # the zero as an equation for orbits; None if the value depends on more than the orbit
    condition: Condition | None = None
    border: tuple[int, int] | None = None  # of a margin: image and code
    # derivative of the value along the curve; None if unknown
    rate: Callable[[Sample], float] | None = None
    name: str = ""  # of one of a curve's own test functions
    # its rounding error: values at both ends that are no larger do not count as a change of sign
    noise: Callable[[SpaceOrbit], float] = lambda _: 0.0
    leaps: bool = False  # a change of sign without a zero is ignored, not an error


@dataclass(frozen=True, slots=True, eq=False)
class SolutionCurve:
    """A problem with one unknown left free, and the test functions along it."""

    map: SpaceMap
    problem: Problem
    settings: CurveSettings
    # margins, by image and code, that vanish all along the curve
    ignored: frozenset[tuple[int, int]] = frozenset()
    tests: tuple[Stop, ...] = MULTIPLIERS  # standard ones: LP, PD, NS, BP
    own: tuple[TestFunction, ...] = ()  # further ones; ``SPECIAL`` where they vanish

    def start(self, orbit: SpaceOrbit, along: Floats | None = None) -> Sample:
        """An orbit as a sample of the curve; its tangent points along a scaled direction."""
        return Sample(orbit, *tangent(self.problem, orbit, along))

    def advance(
        self, last: Sample, distance: float, before: Sample | None = None,
        ahead: Sample | None = None,
    ) -> Sample | None:  # fmt: skip
        """The next sample at a distance along the tangent; None if the corrector fails."""
        # predicted by the cubic through it and the sample before it, or one further ahead
        way = distance * last.tangent
        if before is not None:
            way = way + self._bend(before, last, distance)
        elif ahead is not None:
            way = way + self._bend(ahead.turned, last.turned, -distance)
        if last.orbit.outer is not None and last.orbit.x.shape[1] == 1:
            orbit = self._along_border(last, distance, way)
        else:
            at_distance = across(self.problem, last.orbit, last.tangent, distance)
            guess = self.problem.moved(last.orbit, way)
            if not guess.is_defined:
                guess = pulled_inside(guess, last.orbit)
            found = solve(self.problem.with_(at_distance), guess)
            orbit = found.orbit if found.converged else None
        if orbit is None or not orbit.is_defined:
            return None
        aside = self.problem.step_between(last.orbit, orbit) - distance * last.tangent
        if norm(aside) > distance:  # on another curve
            return None
        sample = self.start(orbit, last.tangent)
        return sample if np.isfinite(sample.tangent).all() else None

    def _along_border(self, last: Sample, distance: float, way: Floats) -> SpaceOrbit | None:
        """Corrector in R^1 for crossings: solve for the points up to the border; s follows."""
        (*_, border), problem = self.problem.conditions, self.problem
        assert isinstance(border, OnBorder)
        to = problem.stepped(last.orbit, way)
        head = head_of(last.orbit, to)
        if not head.is_defined:
            head = pulled_inside(head, head_of(last.orbit, last.orbit.unknowns))
        rounds = length_of(last.orbit.images[-1])
        on = OnBorder(border.image, border.code // rounds)
        heads = replace(problem, conditions=(Chained(), on))
        at_distance = across(problem, last.orbit, last.tangent, float(last.tangent @ way))
        found = solve(heads.with_(at_distance), head)
        return completed(found.orbit, last.orbit) if found.converged else None

    def _bend(self, a: Sample, b: Sample, distance: float) -> Floats:
        """What the cubic through two samples adds to the tangent predictor beyond the second."""
        chord = self.problem.step_between(a.orbit, b.orbit)
        length = norm(chord)
        if length == 0.0:
            return np.zeros(len(chord))
        # With t = part the cubic is b + length (t T_b + t^2 square + t^3 cubic); a lies at t = -1.
        mean, part = chord / length, distance / length
        cubic = b.tangent + a.tangent - 2.0 * mean
        square = 2.0 * b.tangent + a.tangent - 3.0 * mean
        return np.asarray(distance * part * (square + part * cubic))

    def agrees(
        self, orbit: SpaceOrbit, border: tuple[int, int] | None = None, *, is_last: bool = False
    ) -> bool:
        """Whether the map takes the pieces of an orbit; points on borders are not checked.

        These are borders along which the curve leads or at which it ends. In the last sample, at
        the end of a span, points on other borders of their pieces pass too, but none beyond.
        """
        at_border = {orbit.point_of(i) for i, _ in self.ignored}
        if border is not None:
            at_border.add(orbit.point_of(border[0]))
        if is_last:
            at_border |= {orbit.point_of(i) for i, image in enumerate(orbit.all_images)
                          if _is_met(image, orbit.x[orbit.point_of(i)], orbit.p)}  # fmt: skip
        return all(
            i in at_border or self.takes(x, orbit.p, image)
            for i, (x, image) in enumerate(zip(orbit.x, orbit.images, strict=True))
        )

    def takes(self, x: Floats, p: Floats, image: SpaceImage) -> bool:
        """Whether the map takes the piece of an image, with the same event times."""
        # If margins decide, the map need only be asked where one of them vanishes up to rounding.
        if image.reason:
            return False
        if margins_decide(self.map) and not image.tied(x, p).any():
            return bool((image.margins > 0.0).all())
        key, value = taken(self.map, x, p)
        slack = SAME_VALUE * max(1.0, self.problem.steepest(image))
        return key == image.piece.key and self.problem.same(value, image.value, slack)

    def bounds(self, orbit: SpaceOrbit) -> tuple[Ints, Floats, Floats, list[Stop]]:
        """Columns of the bounded unknowns, lower and upper bounds, and the Stop of each."""
        # An unknown held at a value is not bounded: it may be held at an end of the window.
        n, share = len(orbit.x), -1 if orbit.outer is None else len(orbit.unknowns) - 1
        held = tuple(each.column for each in self.problem.conditions if isinstance(each, Held))
        return _limits(self.settings, n, self.problem.free, share, held)

    def all_rates(self, sample: Sample) -> Floats:
        """Derivatives of all unknowns of an orbit along the curve, in arclength."""
        orbit, problem = sample.orbit, self.problem
        wide = np.zeros(orbit.x.size + len(orbit.p) + 1)
        columns, lengths = problem.free_columns(orbit)
        wide[columns] = sample.tangent * lengths
        if orbit.outer is not None and orbit.x.shape[1] == 1:
            wide[-1] = _rate_of_share(orbit, wide)
        return wide

    def motion(self, sample: Sample, i: int) -> Floats:
        """Derivatives (d + k,) of the i-th point and the parameters along the curve."""
        motion: Floats = self._motions(sample)[i]
        return motion

    def rates(self, sample: Sample) -> list[Floats]:
        """Derivatives of all margins of each image along the curve."""
        orbit, motions = sample.orbit, self._motions(sample)
        return [
            image.gradients @ motions[orbit.point_of(i)] for i, image in enumerate(orbit.all_images)
        ]

    def rate(self, sample: Sample, i: int, code: int) -> float:
        """The derivative of the margin with a code of the i-th image along the curve."""
        image = sample.orbit.all_images[i]
        motion = self.motion(sample, sample.orbit.point_of(i))
        return float(image.gradients[image.index_of(code)] @ motion)

    def _motions(self, sample: Sample) -> Floats:
        """(n, d + k) derivatives of all points and the parameters along the curve."""
        (n, d), k = sample.orbit.x.shape, len(sample.orbit.p)
        wide, found = self.all_rates(sample), np.empty((n, d + k))
        found[:, :d] = wide[: n * d].reshape(n, d)
        found[:, d:] = wide[n * d : n * d + k]
        return found

    def limits(self, sample: Sample) -> tuple[float, float, float]:
        """Derivatives of inner limit, outer limit and x_0 of a crossing in R^1 along the curve."""
        orbit, motion = sample.orbit, self.all_rates(sample)
        last = motion[len(orbit.x) - 1 : -1]
        inner, outer = (float(each.jacobian[0] @ last) for each in orbit.all_images[-2:])
        return inner, outer, float(motion[0])


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """A part of a curve, from a sample to what ends it."""

    samples: tuple[Sample, ...]  # the end included
    stop: Stop
    curve: SolutionCurve
    border: tuple[int, int] | None = None  # where it ends at a border: image and code of the margin
    beyond: Sample | None = None  # the next sample, beyond the end
    condition: Condition | None = None  # equation that holds at the end, besides those of the curve
    step: float = math.inf
    width: float = 0.0
    test: TestFunction | None = None  # the test function that vanishes at the end

    @property
    def precision(self) -> float:
        """The error of the first free parameter at the end; infinite if the curve was given up."""
        if self.stop is Stop.SPAN:
            return 0.0
        if self.stop in (*MULTIPLIERS, Stop.ASKED):
            orbit, column = self.samples[-1].orbit, self.curve.problem.free[0]
            scale = self.curve.problem.p_scale[column]
            rate = abs(self.samples[-1].ahead) * scale
            return self.width * rate + MAP_ROUNDING * max(scale, abs(float(orbit.p[column])))
        if self.condition is None:
            return math.inf
        known = uncertainty(self.curve.problem.with_(self.condition), self.samples[-1].orbit)
        return max(known, self._left())

    def _left(self) -> float:
        """The error of the parameter if the end is only close to a border with a root."""
        # At a distance h from the border of a + b sqrt(h) the slope is b / (2 sqrt(h)), and the
        # missing b sqrt(h) is 2 h times the slope; twice as much allows for other exponents.
        if self.border is None:
            return 0.0
        orbit, problem = self.samples[-1].orbit, self.curve.problem
        image = orbit.all_images[self.border[0]]
        k, d = image.index_of(self.border[1]), orbit.x.shape[1]
        away = abs(float(image.margins[k])) / max(norm(image.gradients[k]), SHORTEST_ROW)
        steep = float(np.abs(image.jacobian[:, :d]).max())
        if steep < STEEP or not math.isfinite(steep):
            return 0.0
        return 4.0 * steep * away * problem.p_scale[problem.free[0]] / problem.x_scale[0]


@lru_cache
def _limits(
    settings: CurveSettings, n: int, free: tuple[int, ...], share: int, held: tuple[int, ...]
) -> tuple[Ints, Floats, Floats, list[Stop]]:
    """`SolutionCurve.bounds` for n points; s is not bounded if its column is negative."""
    points = n * len(settings.window)
    columns = [*range(points), *(points + each for each in free), share]
    ends = [*settings.window * n, *settings.spans, (0.0, 1.0)]
    stops = [Stop.WINDOW] * points + [Stop.SPAN] * len(settings.spans) + [Stop.SHARE]
    kept = [k for k, column in enumerate(columns) if column >= 0 and column not in held]
    low, high = np.array(ends)[kept].T
    return np.array(columns)[kept], low, high, [stops[k] for k in kept]


def _rate_of_share(orbit: SpaceOrbit, motion: Floats) -> float:
    """The derivative of s = (x_0 - P) / (P' - P) of a crossing in R^1 along a motion of it."""
    inner, outer = orbit.all_images[-2:]
    n = len(orbit.x)
    rates = [float(each.jacobian[0] @ motion[n - 1 : -1]) for each in (inner, outer)]
    jump = float(outer.value[0] - inner.value[0])
    if jump == 0.0:
        return math.nan
    return float(motion[0] - rates[0] - orbit.share * (rates[1] - rates[0])) / jump


def _is_met(image: SpaceImage, x: Floats, p: Floats) -> bool:
    """Whether a point lies on a border of its piece up to rounding, and beyond no other."""
    tied = image.tied(x, p)
    return bool(tied.any() and (tied | (image.margins > 0.0)).all())


def nearest_border(curve: SolutionCurve, orbit: SpaceOrbit) -> tuple[float, int, int]:
    """The border nearest to any point of an orbit: its scaled distance, its image and its code."""
    scale = np.array(curve.problem.x_scale)
    best = math.inf, 0, 0
    for i, image in enumerate(orbit.all_images):
        slopes = np.linalg.norm(image.gradients[:, : len(scale)] * scale, axis=1)
        for margin, slope, code in zip(image.margins, slopes, image.codes.tolist(), strict=True):
            if (i, code) not in curve.ignored and slope > 0.0:
                best = min(best, (abs(float(margin / slope)), i, code))
    return best
