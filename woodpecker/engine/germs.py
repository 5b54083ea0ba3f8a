"""Curves that start where an orbit meets a border, found from the germ of the map there.

Near a border point the map has two pieces and no others. An orbit through border points therefore
has finitely many *paths*, with one of the two pieces at each of these points. The curves that start
there are cycles along a path that returns, and jump crossings between two paths that part at a
border. A curve is kept if its tangent leads every point to the side of the border of its piece.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from pwmap.diagrams.data import INTERVAL, BranchKind, PointKind
from woodpecker.base.arrays import Floats, norm
from woodpecker.engine.curves import Sample, SolutionCurve, nearest_border
from woodpecker.engine.ends import rounding_of_multipliers
from woodpecker.engine.maps import (
    ACCUMULATE,
    LIMIT_DISTANCE,
    TIE,
    Accumulating,
    Chain,
    SpaceImage,
    SpaceMap,
    accumulated,
    chained,
    image_at,
)
from woodpecker.engine.newton import MAP_ROUNDING, MERGED, Problem
from woodpecker.engine.orbits import (
    Chained,
    Closed,
    Multiplier,
    OnBorder,
    SpaceOrbit,
    first_image_of,
    orbit_of,
)

SAME = 1e-7  # scaled: values of the map that are closer than this are equal
SLOW = 1e-9  # scaled: a margin that changes more slowly along a tangent does not tell its side
KINKED = 1e-5  # relative: rates of two limits along a border that differ by less are equal
PATHS = 256  # of one orbit at most: two pieces at each of eight border points
SECTORS = 16  # pieces that meet at one point, at most
PARALLEL = 1e-7  # borders whose normals differ by a smaller angle are the same [rad]
PART_BEYOND_BORDER = 0.5  # how far to go beyond a border, relative to where another margin vanishes


@dataclass(frozen=True, slots=True, eq=False)
class Beginning:
    """A curve that starts at a point, with its first sample."""

    order: int  # its cycles, or crossings, are those of P_order
    curve: SolutionCurve
    sample: Sample  # the point with the tangent of the curve, or the first sample beside it
    before: Sample | None = None  # the point, if the first sample lies beside it

    @property
    def is_crossing(self) -> bool:
        """Whether it is a curve of jump crossings."""
        return self.sample.orbit.outer is not None

    @property
    def kind(self) -> BranchKind:
        """Whether its samples are cycles or jump crossings."""
        return BranchKind.JUMP if self.is_crossing else BranchKind.FIXED_POINT

    @property
    def key(self) -> Hashable:
        """An identifier among the curves from one point: order and pieces, in a canonical order."""
        keys = self.sample.orbit.keys
        return (self.order, True, keys) if self.is_crossing else _of_cycle(keys)


def _of_cycle(keys: tuple[Hashable, ...]) -> Hashable:
    """The key of a curve of cycles: the least rotation of the keys of their pieces."""
    return len(keys), False, min((keys[i:] + keys[:i] for i in range(len(keys))), key=str)


def paths(
    map_: SpaceMap, x: Floats, p: Floats, order: int, problem: Problem,
    points: Floats | None = None, met: dict[bytes, list[SpaceImage]] | None = None,
) -> list[SpaceOrbit]:  # fmt: skip
    """All paths of P_order from a point (d,); none if they are more than ``PATHS``.

    ``met`` caches the images of points at these parameters.
    """
    # A path that returns to the point, or to one of the ``points`` (m, d), is set exactly there: a
    # steep map would turn rounding into a place off the border. Paths that get lost are dropped.
    found = [SpaceOrbit(np.empty((0, len(x))), p, 0.0, ())]
    known = x[None] if points is None else points
    met = {} if met is None else met
    for _ in range(order):
        longer = []
        for path in found:
            to = path.end if path.images else x
            at = next((each for each in known if problem.same(to, each, TIE)), to)
            so_far, place = np.vstack([path.x, at]), at.tobytes()
            if place not in met:
                met[place] = sides(map_, at, p, problem.lengths)
            longer += [SpaceOrbit(so_far, p, 0.0, (*path.images, each)) for each in met[place]]
        if len(longer) > PATHS:
            return []
        found = longer
    return found


def sides(map_: SpaceMap, x: Floats, p: Floats, lengths: Floats) -> list[SpaceImage]:
    """The images of a point under all pieces around it; those without a value are left out."""
    first = map_.at(x, p)
    codes = first.codes[first.tied(x, p)].tolist()
    if codes:
        own = map_.beside(x, p, first.gradients[first.index_of(codes[0])])
        first = first if own.reason else own  # a piece beside, not the owner of the point
    found = [] if first.reason else [first]
    for image in found:  # the list grows within this loop
        for code in image.codes[image.tied(x, p)].tolist():
            other = image_beside(map_, x, p, direction_across(image, code, x, p, lengths), lengths)
            if not other.reason and all(other.piece.key != each.piece.key for each in found):
                found.append(other)
        if len(found) > SECTORS:
            break
    return found


def image_beside(
    map_: SpaceMap, x: Floats, p: Floats, direction: Floats, lengths: Floats
) -> SpaceImage:
    """The image beside a point in a direction; where pieces accumulate, their limit if any."""
    image = map_.beside(x, p, direction)
    if image.reason != ACCUMULATE:
        return image
    return accumulated(map_, x, p, direction, lengths) or image


def lost_beyond(map_: SpaceMap, x: Floats, p: Floats, returns: int) -> str:
    """Why an orbit from a side of a border point is lost within some returns; empty if none is."""
    found = list[SpaceImage]()
    first = image_at(map_, x, p)
    if first.reason:
        return "" if first.reason == ACCUMULATE else first.reason
    for code in first.codes[first.tied(x, p)].tolist():
        for direction in (1.0, -1.0):
            gradient = first.gradients[first.index_of(code)]
            found.append(map_.beside(x, p, direction * gradient))
    for _ in range(returns):
        found = [each if each.reason else image_at(map_, each.value, p) for each in found]
    return next((each.reason for each in found if each.reason not in ("", ACCUMULATE)), "")


def direction_across(image: SpaceImage, code: int, x: Floats, p: Floats, lengths: Floats) -> Floats:
    """The direction (d + k,) out of a piece, across the border where a margin vanishes."""
    # Where several borders meet it also leads along this one to where their margins grow, and only
    # so far beyond it that they stay positive. Angles are those in scaled unknowns.
    out = -image.gradients[image.index_of(code)] * lengths
    out /= np.linalg.norm(out)
    others = image.gradients[image.tied(x, p)] * lengths
    others /= np.linalg.norm(others, axis=1)[:, None]
    along = others - np.outer(others @ out, out)
    apart = np.linalg.norm(along, axis=1) > PARALLEL
    if not apart.any():
        return np.asarray(out * lengths)
    others, along = others[apart], along[apart]
    way = (along / np.linalg.norm(along, axis=1)[:, None]).sum(axis=0)
    grow, fall = others @ way, -others @ out
    ends = grow[(grow > 0.0) & (fall > 0.0)] / fall[(grow > 0.0) & (fall > 0.0)]
    return np.asarray(
        (way + min(1.0, PART_BEYOND_BORDER * ends.min(initial=math.inf)) * out) * lengths
    )


def shared(
    one: SpaceImage, other: SpaceImage, x: Floats, p: Floats, lengths: Floats
) -> tuple[list[int], list[int]] | None:
    """Codes of the margins of two pieces at a common border, or None; one list may be empty."""
    pieces = [(each, each.codes[each.tied(x, p)].tolist()) for each in (one, other)]
    for code in pieces[0][1]:
        normal = one.gradients[one.index_of(code)] * lengths
        normal /= np.linalg.norm(normal)
        own, beyond = (
            [
                k
                for k in codes
                if _is_parallel(image.gradients[image.index_of(k)], sign * normal, lengths)
            ]
            for (image, codes), sign in zip(pieces, (1.0, -1.0), strict=True)
        )
        if beyond or not pieces[1][1]:
            return own, beyond
    return None


def _is_parallel(gradient: Floats, normal: Floats, lengths: Floats) -> bool:
    gradient = gradient * lengths
    size = float(np.linalg.norm(gradient))
    return float(np.linalg.norm(gradient - size * normal)) <= PARALLEL * size


def beginnings(
    base: SolutionCurve, points: Floats, p: Floats, orders: Sequence[int]
) -> Iterator[Beginning]:
    """All curves of given orders that start where orbits from points (m, d) meet borders.

    The points are those of a cycle, or x_0 of a crossing. The curves consist of cycles, or of jump
    crossings that start at s = 0 or 1, at a second border, or where the jump itself opens.
    """
    seen, met = set[Hashable](), dict[bytes, list[SpaceImage]]()
    for order in orders:
        for x in points:
            all_ = paths(base.map, x, p, order, base.problem, points, met)
            new = [path for path in all_ if _of_cycle(path.keys) not in seen]
            for begin in (*_cycles(base, new, points, x, p), *_crossings(base, all_, x, p)):
                if begin.key not in seen:
                    seen.add(begin.key)
                    yield begin


def _cycles(
    base: SolutionCurve, all_: Sequence[SpaceOrbit], points: Floats, x: Floats, p: Floats
) -> Iterator[Beginning]:
    """Cycles along paths that return to the point and do not repeat a shorter path."""
    # Points of a cycle may be closer than SAME: compare also which known point is the nearest.
    scale = np.array(base.problem.x_scale)

    def nearest(to: Floats) -> int:
        return int(np.abs((points - to) / scale).max(axis=1).argmin())

    for path in all_:
        steps = [
            (image.piece.key, nearest(at)) for image, at in zip(path.images, path.x, strict=True)
        ]
        order = len(steps)
        goes_round = any(
            steps[d:] + steps[:d] == steps and base.problem.same(path.x[d:], path.x[:-d], SAME)
            for d in range(1, order)
            if order % d == 0
        )
        returns = base.problem.same(path.end, x, SAME) and nearest(path.end) == nearest(x)
        is_limit = any(isinstance(image.piece, Accumulating) for image in path.images)
        if returns and not goes_round and not is_limit:
            yield from _both_ways(order, base, path)


def _crossings(
    base: SolutionCurve, all_: Sequence[SpaceOrbit], x: Floats, p: Floats
) -> Iterator[Beginning]:
    """Jump crossings between two paths that start at a limit, a second border or a new jump."""
    for begin in _between(base, all_, x, p):
        orbit = begin.sample.orbit
        inner, outer = orbit.all_images[-2:]
        vanishes = base.problem.same(inner.value, outer.value, SAME)
        inside = 0.0 < orbit.share < 1.0 and not meets_border(orbit, begin.curve.ignored)
        if vanishes or not inside:
            yield from _both_ways(begin.order, begin.curve, orbit)


def crossings_at(base: SolutionCurve, head: Floats, p: Floats, order: int) -> list[Beginning]:
    """The jump crossings of P_order with given points (n, d) up to their border."""
    first = tuple(base.map.at(x, p) for x in head[:-1])
    all_ = [
        SpaceOrbit(np.vstack([head[:-1], path.x]), p, 0.0, (*first, *path.images))
        for path in paths(base.map, head[-1], p, order - len(first), base.problem)
    ]
    found = _between(base, all_, head[0], p)
    return [
        each
        for each in found
        if len(each.sample.orbit.x) == len(head)
        and 0.0 < each.sample.orbit.share < 1.0
        and not meets_border(each.sample.orbit, each.curve.ignored, beyond=True)
    ]


def _between(
    base: SolutionCurve, all_: Sequence[SpaceOrbit], x: Floats, p: Floats
) -> Iterator[Beginning]:
    """All jump crossings between two paths, whether or not a curve of them starts here."""
    problem = base.problem
    for one, other in combinations(all_, 2):
        parts = [a.piece.key != b.piece.key for a, b in zip(one.images, other.images, strict=True)]
        head = parts.index(True) + 1
        sides = one.images[head - 1], other.images[head - 1]
        if problem.same(sides[0].value, sides[1].value, _resolved(problem, sides)):
            opens = _opening(base, one, other, head, p) if problem.same(one.end, x, SAME) else None
            if opens is not None:
                yield opens
            continue
        if _locates_border_worse(one, other, head - 1, p):
            one, other = other, one
        way = (other.end - one.end) / problem.x_scale
        length = float(way @ way)
        share = float((x - one.end) / problem.x_scale @ way) / length if length > 0.0 else -1.0
        if not (-SAME <= share <= 1.0 + SAME):
            continue
        share = 0.0 if abs(share) <= SAME else 1.0 if abs(share - 1.0) <= SAME else share
        if not problem.same(one.end + share * (other.end - one.end), x, SAME):
            continue
        limits = one.images[head - 1 :], other.images[head - 1 :]
        found = joined(base, one.images[: head - 1], limits, one.x[:head], p, share)
        if found is not None:
            yield found


def _resolved(problem: Problem, sides: tuple[SpaceImage, SpaceImage]) -> float:
    """The least distance of two limits, scaled, that is a jump and not a rounding error."""
    # With a root a + b sqrt(h), the limit is off by b sqrt(r) if the border is off by the rounding
    # r. At the distance d of LIMIT_DISTANCE, where limits are taken, the slope is b / (2 sqrt(d)).
    steepest = max(map(problem.steepest, sides))
    return max(SAME, 2.0 * steepest * math.sqrt(LIMIT_DISTANCE * MAP_ROUNDING))


def _opening(
    base: SolutionCurve, one: SpaceOrbit, other: SpaceOrbit, head: int, p: Floats
) -> Beginning | None:
    """The crossing in R^1 of a jump that opens here, with zero height; None if none opens."""
    # Here s = (x_0 - P) / (P' - P) is 0/0: its limit is the ratio of the rates along the border.
    if len(one.x[0]) > 1 or len(base.problem.free) > 1:
        return None
    sides = one.images[head - 1 :], other.images[head - 1 :]
    found = joined(base, one.images[: head - 1], sides, one.x[:head], p, 0.5)
    if found is None:
        return None
    orbit = found.sample.orbit
    inner, outer, first = found.curve.limits(found.curve.start(orbit))
    apart = outer - inner
    share = (first - inner) / apart if abs(apart) > KINKED * abs(first) else math.nan
    if not SAME < share < 1.0 - SAME:
        return None
    return replace(found, sample=Sample(replace(orbit, share=share), np.empty(0)))


def joined(
    base: SolutionCurve, heads: Sequence[SpaceImage],
    limits: tuple[Sequence[SpaceImage], Sequence[SpaceImage]], x: Floats, p: Floats, share: float,
) -> Beginning | None:  # fmt: skip
    """The crossing, without tangent, between two limits, given the images before them, or None."""
    sides = limits[0][0], limits[1][0]
    border = shared(*sides, x[-1], p, base.problem.lengths)
    if border is None:
        return None
    inner, outer = map(chained, limits)
    last, rounds = len(heads), len(limits[0])  # how `chained` numbers margins
    ignored = frozenset(
        (last + k, rounds * code) for k, codes in enumerate(border) for code in codes
    )
    closing = Chained() if x.shape[1] == 1 else Closed()  # on the line the border alone locates it
    conditions = (closing, OnBorder(last, rounds * border[0][0]))
    curve = replace(base, problem=replace(base.problem, conditions=conditions), ignored=ignored)
    orbit = SpaceOrbit(x, p, share, (*heads, inner), outer)
    return Beginning(last + rounds, curve, Sample(orbit, np.empty(0)))


def _locates_border_worse(one: SpaceOrbit, other: SpaceOrbit, i: int, p: Floats) -> bool:
    """Whether the second path locates the border better: at a jump a root may end on one side."""
    known, steepness = (
        [bool(path.images[i].tied(path.x[i], p).any()) for path in (one, other)],
        [float(np.abs(path.images[i].jacobian).max()) for path in (one, other)],
    )
    return known[1] and (not known[0] or steepness[0] > steepness[1])


def meets_border(
    orbit: SpaceOrbit, ignored: frozenset[tuple[int, int]] = frozenset(), *, beyond: bool = False
) -> bool:
    """Whether a margin not in ``ignored`` vanishes (with ``beyond``: and is not positive)."""
    for i, image in enumerate(orbit.all_images):
        zero = image.tied(orbit.x[orbit.point_of(i)], orbit.p)
        if beyond:
            zero &= image.margins <= 0.0
        if any((i, code) not in ignored for code in image.codes[zero].tolist()):
            return True
    return False


def _both_ways(order: int, curve: SolutionCurve, orbit: SpaceOrbit) -> Iterator[Beginning]:
    """The curve through an orbit in both directions, where its points lie in their pieces."""
    sample = curve.start(orbit)
    if not np.isfinite(sample.tangent).all():
        return
    ways = [
        each
        for each in (sample, sample.turned)
        if is_inside(curve, each) and _is_taken_ahead(curve, each)
    ]
    away, *border = nearest_border(curve, orbit)
    if len(ways) == 2 and math.isfinite(away):  # rounding puts the orbit beside the border
        ways.sort(key=lambda each: curve.rate(each, *border), reverse=True)
    for each in ways:
        yield Beginning(order, curve, each)


def _is_taken_ahead(curve: SolutionCurve, sample: Sample) -> bool:
    """Whether pieces without a margin at a border point are those that the map takes ahead."""
    orbit, map_ = sample.orbit, curve.map
    for i, (x, image) in enumerate(zip(orbit.x, orbit.images, strict=True)):
        if image.tied(x, orbit.p).any():
            continue
        here, key = map_.at(x, orbit.p), image.piece.key
        on_border = here.piece.key != key or here.tied(x, orbit.p).any()
        if on_border and map_.beside(x, orbit.p, curve.motion(sample, i)).piece.key != key:
            return False
    return True


def slow_rate(problem: Problem, image: SpaceImage, k: int) -> float:
    """The scaled rate below which the k-th margin of an image counts as constant."""
    # In R^d a margin may be small in all directions, as a gap of micrometres: use its gradient.
    if len(problem.x_scale) == 1:
        return SLOW
    return SLOW * min(1.0, norm(image.gradients[k] * problem.lengths))


def is_inside(curve: SolutionCurve, sample: Sample) -> bool:
    """Whether all margins that vanish at a sample grow along the curve, and others are positive."""
    orbit = sample.orbit
    for i, image in enumerate(orbit.all_images):
        zero = image.tied(orbit.x[orbit.point_of(i)], orbit.p)
        for k, code in enumerate(image.codes.tolist()):
            if (i, code) in curve.ignored:
                continue
            slow = slow_rate(curve.problem, image, k)
            if not (curve.rate(sample, i, code) > slow if zero[k] else image.margins[k] > 0.0):
                return False
    if orbit.outer is None:
        return True
    rises = float(curve.all_rates(sample)[-1])
    return (orbit.share > 0.0 or rises > SLOW) and (orbit.share < 1.0 or rises < -SLOW)


def rotated_to_nearest(begin: Beginning, x: Floats) -> Beginning:
    """Rotate the cycle of a beginning so that its first point is the nearest to a point (d,)."""
    sample, problem = begin.sample, begin.curve.problem
    orbit, size = sample.orbit, sample.orbit.x.size
    first = min(range(len(orbit.x)), key=lambda i: problem.apart(orbit.x[i], x))
    rolled = np.roll(sample.tangent[:size], -first * orbit.x.shape[1])
    tangent = np.concatenate((rolled, sample.tangent[size:]))
    return replace(begin, sample=Sample(orbit.rotated(first), tangent, sample.bordered))


def cycle_through(
    map_: SpaceMap, x: Floats, p: Floats, orders: Sequence[int], base: Problem
) -> SpaceOrbit | None:
    """The shortest cycle of given orders through a point, along one of its paths, or None."""
    for order in sorted(orders):
        for path in paths(map_, x, p, order, base):
            if base.same(path.end, x, SAME):
                return least_period(path, base)
    return None


def cycle_at_limit(crossing: SpaceOrbit, base: Problem) -> SpaceOrbit:
    """The cycle to which a jump crossing closes at s = 0 or 1, in its least period."""
    last = crossing.images[-1]
    if crossing.outer is not None and crossing.share > 0.5:
        last = crossing.outer
    tail = last.piece.pieces if isinstance(last.piece, Chain) else (last.piece,)
    points, pieces = list(crossing.x), [image.piece for image in crossing.images[:-1]]
    points.append(first_image_of(last, crossing.x[-1], crossing.p).value)
    for piece in tail[1:]:
        points.append(piece.at(points[-1], crossing.p).value)
    pieces += tail
    # Start from the border point itself: rounding would put its image beside the border.
    border = len(crossing.x) - 1
    cycle = least_period(orbit_of(pieces, np.array(points[:-1]), crossing.p).rotated(border), base)
    return cycle.rotated(-border % len(cycle.x))


def least_period(cycle: SpaceOrbit, base: Problem) -> SpaceOrbit:
    """Reduce a cycle to its least period."""
    period = base.period(cycle.x, MERGED)
    return SpaceOrbit(cycle.x[:period], cycle.p, 0.0, cycle.images[:period])


def collision_kind(
    starts: Sequence[Beginning], cycle: Floats, i: int, problem: Problem
) -> tuple[PointKind, str]:
    """Kind and note of a border collision at point i of a cycle, by the curves that start there."""
    # Curves of its own order lie on both sides of the parameter (persistence) or on one (fold). In
    # a fold-flip a cycle folds into a jump crossing, and a crossing of twice the order starts at
    # the preimage of the jump. In R^1 it does where the multiplier of the cycle exceeds 1: this
    # tells more than the start, which has no tangent if the multiplier is infinite.
    own, order, twice = list[Beginning](), len(cycle), False
    for begin in starts:
        orbit = begin.sample.orbit
        away = orbit.x[: 1 if begin.is_crossing else None, None] - cycle
        nearest = np.abs(away / problem.x_scale).max(axis=2).argmin(axis=1)
        count = int((nearest == i).sum())
        if begin.order == order:
            own += count * [begin]
        at_preimage = begin.is_crossing and begin.order == 2 * order < 2 * len(orbit.x)
        twice |= at_preimage and count > 0
    level = [begin for begin in own if is_level(begin.sample, problem)]
    cycles = [begin for begin in own if not begin.is_crossing]
    if cycles and all(begin in level for begin in cycles):
        return PointKind.BC, INTERVAL
    if len(own) < 2:  # behind a flat piece there is no jump: the cycle ends alone
        is_flat = any(not begin.sample.orbit.monodromy.any() for begin in cycles)
        return PointKind.BC, "fold" if is_flat else ""
    sides = {begin.sample.rate > 0.0 for begin in own if begin not in level}
    note = "fold" if len(sides) == 1 else "persistence"
    if cycles and cycle.shape[1] == 1:
        twice = abs(float(cycles[0].sample.orbit.monodromy[0, 0])) > 1.0
    flips = twice and note == "fold" and len(cycles) == 1
    return (PointKind.FF if flips else PointKind.BC), note


def is_level(sample: Sample, problem: Problem) -> bool:
    """Whether a curve stays at one parameter: a multiplier is 1, or a crossing's slope is 0."""
    if sample.orbit.outer is not None or sample.ahead != 0.0:
        return sample.rate == 0.0
    return is_neutral(sample.orbit, problem)


def is_neutral(cycle: SpaceOrbit, problem: Problem) -> bool:
    """Whether a multiplier of a cycle is 1 up to rounding."""
    away = abs(Multiplier("LP").value(cycle))
    return away <= rounding_of_multipliers(cycle, problem.x_scale)
