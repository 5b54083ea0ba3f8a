"""A rectangle of two parameters, cut into regions with the same cycles.

Curves cut the rectangle into faces. Cycles are counted at one place of each face and at random
places. If two places of a face disagree, an unknown curve lies between them: the way from one to
the other is halved, and then a diagram over one parameter finds the special point on it, which is
followed in both. This is repeated until all random places agree.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from itertools import product
from pathlib import Path

import numpy as np
import numpy.typing as npt
import shapely
from shapely import LineString, MultiLineString, Point, Polygon
from shapely.ops import unary_union

from pwmap.diagrams.diagram import PointStatus, SpecialPoint
from pwmap.diagrams.saved import read_record, write_record
from pwmap.diagrams.shown import counted
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import interval, number
from woodpecker.base.settings import Settings
from woodpecker.plane.curve import Curve, check_curve
from woodpecker.plane.families import Family, Pair, Spans
from woodpecker.plane.following import curve_through
from woodpecker.plane.starting import has_curve
from woodpecker.regions.census import Census, SampledAttractor, attractors_at, census_at
from woodpecker.regions.cutting import (
    SQUARE,
    faces_of,
    faces_of_places,
    inner_place,
    lines_of,
    scaled,
    unscaled,
    way_between,
)
from woodpecker.regions.survey import Survey
from woodpecker.search.diagrams import whole_diagram
from woodpecker.search.search import Search

NAME, VERSION = "regions", 1  # of saved files; raised by a change that older code would misread
TRIES = 3  # searches for a curve near a place that disagrees with its face
FINEST = 2.0**-40  # fraction of the spans: closer places are equal up to rounding
DRAWS = 100  # rounds of random places, until enough of them are far from all borders
PROBES = 9  # sampled places of a curve that must lie on another one, if it is part of it

Progress = Callable[[Curve], None]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Region:
    """A part of the rectangle with the same cycles.

    Attributes
    ----------
    outline, holes
        Its outer border (k, 2) and those of its holes, as closed rings.
    share, place
        Fraction of the area of the rectangle, and parameters inside the region.
    census
        Numbers of cycles by period and stability.
    attractors
        Attractors at ``place``. They may change within the region, for instance with cycles of
        other periods or where an attractor meets the border of its basin.
    agree
        Number of random places inside it with the same census.

    Examples
    --------
    >>> from woodpecker.examples import paper_regions
    >>> found = paper_regions()
    >>> [(round(region.share, 6), len(region.census)) for region in found.regions]
    [(0.5, 1), (0.5, 1)]
    """

    outline: Floats = field(repr=False)
    holes: tuple[Floats, ...] = field(repr=False)
    share: float
    place: Pair
    census: Census
    attractors: tuple[SampledAttractor, ...]
    agree: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Regions:
    """A rectangle of two parameters, cut into regions with the same cycles.

    Attributes
    ----------
    names, spans, orders
        The parameters, their intervals, and the periods of the cycles that are counted.
    curves, regions
        The curves, given ones first; the regions, in descending order of area.
    checks
        Number of random places compared after the last curve was found.
    open
        Places with a census other than that of their region, and this census: a curve is missing.

    Examples
    --------
    >>> from woodpecker.examples import paper_regions
    >>> found = paper_regions()
    >>> found.names, len(found.curves), len(found.regions)
    (('r', 'a'), 1, 2)
    """

    names: tuple[str, str]
    spans: Spans
    orders: tuple[int, ...]
    curves: tuple[Curve, ...]
    regions: tuple[Region, ...]
    checks: int
    open: tuple[tuple[Pair, Census], ...]

    def __repr__(self) -> str:
        curves, checks = counted(len(self.curves), "curve"), counted(self.checks, "check")
        return (
            f"Regions({len(self.regions)} over {', '.join(self.names)}, {curves}, "
            f"{checks}, {len(self.open)} open)"
        )

    def at(self, first: float, second: float) -> Region:
        """The region that holds the parameters ``first`` and ``second``.

        ValueError on a border or outside the rectangle.
        """
        both = [number(n, value) for n, value in zip(self.names, (first, second), strict=True)]
        point = Point(scaled(np.array(both), self.spans))
        for region, polygon in zip(self.regions, self._polygons, strict=True):
            if polygon.contains(point):
                return region
        raise ValueError(f"expected parameters within a region, got ({first}, {second})")

    def save(self, path: str | Path) -> Path:
        """Write JSON for :func:`woodpecker.regions.load_regions`, compressed if it ends in .gz."""
        return write_record(path, self, NAME, VERSION)

    @cached_property
    def _polygons(self) -> list[Polygon]:
        found = []
        for region in self.regions:
            rings = [scaled(ring, self.spans) for ring in (region.outline, *region.holes)]
            found.append(Polygon(rings[0], rings[1:]))
        return found


def load_regions(path: str | Path) -> Regions:
    """Read regions that :meth:`Regions.save` wrote.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    Regions
        Equal to the saved ones to the last bit, including their curves.

    Raises
    ------
    ValueError, FileNotFoundError
        If the file holds no regions, is of a newer version, or does not exist.

    Examples
    --------
    >>> from woodpecker.examples import paper_regions
    >>> from woodpecker.regions import load_regions
    >>> load_regions(paper_regions().save("regions.json"))
    Regions(2 over r, a, 1 curve, 4 checks, 0 open)
    """
    regions: Regions = read_record(path, Regions, NAME, VERSION, check=_check)
    return regions


def _check(found: Regions) -> None:
    """ValueError unless the spans, borders and curves of a file can be those of regions."""
    for name, span in zip(found.names, found.spans, strict=True):
        interval(f"span of {name}", span, finite=True)
    for region in found.regions:
        for ring in (region.outline, *region.holes):
            closed = ring.ndim == 2 and ring.shape[1] == 2 and (ring[0] == ring[-1]).all()
            if not (closed and len(ring) > 3 and np.isfinite(ring).all()):
                raise ValueError("a border of a region must be a closed ring of places")
    for curve in found.curves:
        if curve.names != found.names:
            raise ValueError(f"the curves of these regions must be over {', '.join(found.names)}")
        check_curve(curve)


class Division:
    """The faces of a rectangle and the censuses of places in it, while curves are found.

    An orbit is lost where it leaves the interval ``within``.
    """

    def __init__(
        self, family: Family, spans: Spans, settings: Settings, orders: tuple[int, ...],
        survey: Survey, within: Pair,
    ) -> None:  # fmt: skip
        self.family, self.spans, self.orders, self.survey = family, spans, orders, survey
        self.within = within
        self.settings = tuple(replace(settings, span=each) for each in spans)
        self.curves = list[Curve]()
        self.places = dict[Pair, Census]()
        self.census = cache(self._census)
        self.tries = Counter[Pair]()
        self.given_up = list[Pair]()
        self.lines: MultiLineString = lines_of((), spans, self.survey.beside)
        self.faces = faces_of(self.lines)
        self._random = np.random.default_rng(survey.seed)
        self.fresh = list[Pair]()

    # --- Counting -----------------------------------------------------------------------------

    def _census(self, place: Pair) -> Census:
        values = unscaled(place, self.spans)
        map_ = self.family.over(0, values)
        return census_at(map_, values[0], self.orders, self.settings[0])

    def look(self, place: Pair) -> None:
        """Count the cycles at a place and keep the census for its face."""
        self.places[place] = self.census(place)

    def add(self, curve: Curve) -> None:
        """Add a curve, drop those that are parts of it, and cut the faces anew."""
        self.curves = [each for each in self.curves if not self._is_known(each, curve)]
        self.curves.append(curve)
        self.lines = lines_of(self.curves, self.spans, self.survey.beside)
        self.faces = faces_of(self.lines)

    def clear(self, places: Sequence[Pair]) -> npt.NDArray[np.bool_]:
        """Whether each of n places is far from all borders."""
        away = shapely.distance(shapely.points(np.reshape(places, (-1, 2))), self.lines)
        return ~np.asarray(away <= self.survey.beside)  # if there are no lines, `away` is nan

    def faces_with_places(self) -> list[tuple[Polygon, list[Pair]]]:
        """The faces, but for thin ones, each with its counted places far from borders."""
        looked = list(self.places)
        looked = [place for place, far in zip(looked, self.clear(looked), strict=True) if far]
        inside = dict[int, list[Pair]]()
        for place, face in zip(looked, faces_of_places(looked, self.faces), strict=True):
            inside.setdefault(face, []).append(place)
        found = []
        for k, face in enumerate(self.faces):
            if k in inside:
                found.append((face, inside[k]))
                continue
            place, radius = inner_place(face)
            if radius >= self.survey.thin:
                self.look(place)
                found.append((face, [place]))
        return found

    # --- Search for curves --------------------------------------------------------------------

    def complete(self, progress: Progress) -> None:
        """Find curves until all random places agree with their faces."""
        # It ends: each pass finds one of finitely many curves or uses up a try of a place.
        drawn = False
        while True:
            pair = self._conflict()
            if pair is None:
                if drawn:
                    return
                self.fresh, drawn = [*self._draw()], True
                for place in self.fresh:
                    self.look(place)
                continue
            found = self._between(pair) if len(self.curves) < self.survey.curves else []
            for curve in found:
                self.add(curve)
                progress(curve)
            if found:
                self.fresh, drawn = [], False
            else:
                self.tries[pair[-1]] += 1

    def _draw(self) -> Iterator[Pair]:
        """Random places far from borders; fewer than asked for if those are rare."""
        left = self.survey.checks
        for _ in range(DRAWS):
            if not left:
                return
            drawn = [(x, y) for x, y in self._random.random((left, 2)).tolist()]
            far = [place for place, clear in zip(drawn, self.clear(drawn), strict=True) if clear]
            left -= len(far)
            yield from far

    def _conflict(self) -> list[Pair] | None:
        """A way between the closest two places of a face that disagree; None if all agree."""
        # One of them has the most frequent census of the face. Straight ways come first; others
        # lead round curves.
        best, least = None, (True, math.inf)
        for face, own in self.faces_with_places():
            usual = self._most(own)
            odd = [b for b in own if self.places[b] != usual and self.tries[b] < TRIES]
            for a, b in product([a for a in own if self.places[a] == usual], odd):
                way = LineString([a, b])
                rank = not face.contains(way) or way.intersects(self.lines), math.dist(a, b)
                if rank < least:
                    best, least = (face, a, b), rank
        if best is None:
            return None
        _, a, b = best
        return way_between(best[0], self.lines, a, b, 0.5 * self.survey.beside) or [a, b]

    def _between(self, way: Sequence[Pair]) -> list[Curve]:
        a, b = self._narrowed(way)
        near = self.survey.beside
        if LineString([a, b]).intersects(self.lines) or any(
            math.dist(a, c) < near for c in self.given_up
        ):
            return []
        corner = b[0], a[1]
        legs = [(axis, one, other) for axis, one, other in ((0, a, corner), (1, corner, b))
                if self.census(one) != self.census(other)]  # fmt: skip
        found = list[Curve]()
        for axis, one, other in legs:
            for point, value in self._points(axis, one, other):
                curve = self._followed(point, value, axis)
                if curve is not None and not any(self._is_known(curve, each) for each in found):
                    found.append(curve)
        if not found:
            self.given_up.append(a)
        return found

    def _narrowed(self, way: Sequence[Pair]) -> tuple[Pair, Pair]:
        """Narrow a way to two close places on it that disagree as its ends do."""
        first, k, last = self.census(way[0]), 0, len(way) - 1
        while last - k > 1:  # bisection
            half = (k + last) // 2
            k, last = (half, last) if self.census(way[half]) == first else (k, half)
        a, b = way[k], way[last]
        while math.dist(a, b) > max(self.survey.finest, FINEST):  # bisection
            middle = 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])
            if self.census(middle) == first:
                a = middle
            else:
                b = middle
        return a, b

    def _points(self, axis: int, one: Pair, other: Pair) -> list[tuple[SpecialPoint, float]]:
        """Located special points between two places that differ in one parameter, and the other."""
        ends = sorted((unscaled(one, self.spans), unscaled(other, self.spans)))
        low, high = ends[0][axis], ends[1][axis]
        room = 0.5 * (high - low)
        settings = replace(self.settings[axis], span=(low - room, high + room))
        found = whole_diagram(
            self.family.over(axis, ends[0]), settings, self.orders, Search(slices=4, finest=0.01)
        )
        return [
            (point, ends[0][1 - axis])
            for point in found.diagram.points
            if has_curve(point) and point.status is PointStatus.LOCATED
        ]

    def _followed(self, point: SpecialPoint, other: float, axis: int) -> Curve | None:
        """The curve of a special point; None if there is none or it is known."""
        settings = replace(self.settings[0], max_samples=self.survey.samples)
        try:
            curve = curve_through(
                self.family, point, other, axis=axis, span=self.spans, settings=settings
            )
        except ValueError:  # not found again, or on the edge of the span
            return None
        return None if any(self._is_known(curve, each) for each in self.curves) else curve

    def _is_known(self, curve: Curve, other: Curve) -> bool:
        if (curve.kind, curve.order) != (other.kind, other.order) or len(other) < 2:
            return False
        points = scaled(other.values, self.spans)
        line, slack = LineString(points), self.survey.beside * self.settings[0].x_scale
        for k in np.linspace(0, len(curve) - 1, PROBES).astype(int).tolist():
            here = scaled(curve.values[k], self.spans)
            if Point(here).distance(line) > self.survey.beside:
                return False
            near = int(np.abs(points - here).sum(axis=1).argmin())
            x = np.sort(other.x[max(near - 1, 0) : near + 2], axis=1)
            away = float(np.abs(x - np.sort(curve.x[k])).max(axis=1).min())
            if away > slack + float(np.ptp(x, axis=0).max()):
                return False
        return True

    # --- The result ---------------------------------------------------------------------------

    def result(self) -> Regions:
        """Merge neighbouring faces with the same census to regions."""
        shown, parts = list[tuple[Census, Polygon]](), dict[Census, list[Polygon]]()
        counted = {id(face): self._most(own) for face, own in self.faces_with_places()}
        for face in self.faces:
            census = counted.get(id(face)) or self._neighbour(face, counted)
            parts.setdefault(census, []).append(face)
        for census, faces in parts.items():
            pieces = shapely.get_parts(unary_union(faces))
            shown += [(census, piece) for piece in pieces if isinstance(piece, Polygon)]
        shown.sort(key=lambda each: -each[1].area)
        looked = list(self.places)
        inside = faces_of_places(looked, [piece for _, piece in shown])
        differ = [
            (unscaled(place, self.spans), self.places[place])
            for place, clear, k in zip(looked, self.clear(looked), inside, strict=True)
            if clear and k >= 0 and self.places[place] != shown[k][0]
        ]
        return Regions(
            names=self.family.names, spans=self.spans, orders=self.orders,
            curves=tuple(self.curves), regions=tuple(self._region(*each) for each in shown),
            checks=len(self.fresh), open=tuple(differ),
        )  # fmt: skip

    def _most(self, places: Sequence[Pair]) -> Census:
        every = [self.places[place] for place in places]
        return max(every, key=every.count)

    def _neighbour(self, face: Polygon, counted: dict[int, Census]) -> Census:
        """The census of the face that shares the longest border with a thin one."""

        def shared(other: Polygon) -> float:
            return float(face.boundary.intersection(other.boundary).length)

        others = (other for other in self.faces if id(other) in counted)
        return counted.get(id(max(others, key=shared, default=None)), ())

    def _region(self, census: Census, polygon: Polygon) -> Region:
        place, _ = inner_place(polygon)
        values = unscaled(place, self.spans)
        return Region(
            outline=self._ring(polygon.exterior.coords),
            holes=tuple(self._ring(ring.coords) for ring in polygon.interiors),
            share=float(polygon.area / SQUARE.area),
            place=values,
            census=census,
            attractors=attractors_at(
                self.family.over(0, values), values[0], self.settings[0], self.within, self.survey,
            ),
            agree=sum(
                self.places[each] == census and polygon.contains(Point(each)) for each in self.fresh
            ),
        )  # fmt: skip

    def _ring(self, coordinates: Sequence[tuple[float, ...]]) -> Floats:
        return np.array([unscaled(each, self.spans) for each in coordinates])
