"""Certificates: results of pwmap in a form that :mod:`pwmap.checking` verifies independently."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import groupby, pairwise, product
from typing import Any, NoReturn

import sympy
from sympy import QQ
from sympy.polys.matrices import DomainMatrix

from pwmap.algebra.arguments import explained, shown
from pwmap.algebra.exact import HIGHEST, LOWEST, Number, dense, pair
from pwmap.algebra.numbers import Element
from pwmap.algebra.roots import (
    Dense,
    Real,
    RealRoot,
    algebraic,
    integers,
    real_roots,
    sign_at,
    simplest_between,
)
from pwmap.checking import branches, certificate, points
from pwmap.checking import check_certificate as check_certificate
from pwmap.checking.iterates import CheckedIterate, Map
from pwmap.checking.polynomials import Number as CheckedNumber
from pwmap.checking.polynomials import Place
from pwmap.checking.reading import number, read_map
from pwmap.checking.refusing import Effort
from pwmap.checking.refusing import Refused as Refused
from pwmap.diagrams.data import Branch, BranchKind, PointKind, SpecialPoint, Stretch
from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.queries import quotient_in
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, checked_order
from pwmap.maps.words import Table
from pwmap.parameters.cells import checked_orders, with_divisors
from pwmap.proofs.document import Certificate

Row = dict[str, Any]
CERTIFIED = (PointKind.BC, PointKind.FF, PointKind.PD, PointKind.LP)


@explained()
def prove(
    what: PiecewiseLinearMap | Diagram,
    map_: PiecewiseLinearMap | None = None,
    *,
    order: int = 1,
    orders: Iterable[int] | None = None,
) -> Certificate:
    """A certificate of results on a map, which can be verified without this package.

    Parameters
    ----------
    what
        A map without parameters, to certify all fixed points of an iterate and its jumps over the
        diagonal; or a diagram over the only parameter, for its branches and special points.
    map_
        The map, if ``what`` is a diagram.
    order
        The order of the iterate, if ``what`` is a map.
    orders
        Orders of iterates in a diagram, completed by divisors; by default those with branches.

    Returns
    -------
    Certificate
        Already verified once by the functions of the checker.

    Raises
    ------
    ValueError
        If the result cannot be certified; a sentence says why.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, prove
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((2*x, x <= 1/2), (2 - 2*x, True))")
    >>> certificate = prove(tent)
    >>> print(certificate.statement[:71])
    For the map with the pieces L: 2 x for x <= 1/2; R: -2 x + 2 for 1/2 <
    >>> certificate.save("tent.json").name
    'tent.json'
    """
    if isinstance(what, PiecewiseLinearMap):
        if map_ is not None or orders is not None:
            raise ValueError("of a map, only an order can be given: prove(map, order=2)")
        return _sealed(_fixed_points(what, checked_order(order)))
    if not isinstance(what, Diagram) or not isinstance(map_, PiecewiseLinearMap):
        got = shown(what) if map_ is None else f"{shown(what)} and {shown(map_)}"
        raise ValueError(f"a map, or a diagram and its map, was expected, got {got}")
    if order != 1:
        raise ValueError(
            "of a diagram, only orders can be given: prove(diagram, map, orders=(1, 2))"
        )
    return _sealed(_DiagramWriter(what, map_, orders).content())


def _sealed(content: Row) -> Certificate:
    head = {"format": certificate.FORMAT, "version": 1, "kind": content.pop("kind")}
    content = {**head, "statement": "", **content, "seal": ""}
    try:
        content["statement"] = certificate.statement_of(content)
    except Refused as error:
        _fail(str(error))
    content["seal"] = certificate.seal_of(content)
    certificate.check(content)
    return Certificate(content)


def _fail(reason: str) -> NoReturn:
    raise ValueError(f"this cannot be certified: {reason}") from None


# --- Maps -----------------------------------------------------------------------------------------


def _text(number: Number) -> str:
    value = Fraction(*pair(number))
    try:
        return str(value)
    except ValueError:  # more digits than Python writes, which the checker could not read either
        _fail(f"{shown(value)} has more digits than can be checked")


def _rational(expr: sympy.Expr) -> str | None:
    """The text of a sympy rational for the checker; None for any other number."""
    return _text(QQ.from_sympy(expr)) if expr.is_Rational else None


def _map(map_: PiecewiseLinearMap, parameter: str | None) -> tuple[Row, int]:
    if set(map_.chain) != {map_.chain[0]}:
        _fail("a composition of different maps, only iterates of one map are")
    names = [str(symbol) for symbol in map_.parameters]
    if parameter is None and names:
        _fail(f"give values (.at) to the parameters {', '.join(names)}")
    if parameter is not None and names != [parameter]:
        _fail(f"the map must have the parameter {parameter} alone, it has {names or 'none'}")
    table: Table = map_.definition.table
    layout = table.layouts[map_.chain[0]]

    def written(value: Number) -> str | list[str]:
        if parameter is None:
            return _text(value)
        return [_text(c) for c in reversed(dense(value))]

    pieces = {
        map_.letters[i]: {"slope": written(table.slopes[i]),
                          "intercept": written(table.intercepts[i])}
        for i in dict.fromkeys(layout.slots)
    }  # fmt: skip
    return {
        "variable": str(map_.x),
        "parameter": parameter,
        "slots": "".join(map_.letters[slot] for slot in layout.slots),
        "pieces": pieces,
        "breaks": [written(table.breaks[k]) for k in layout.breaks],
        "denominator": written(table.denominator),
    }, len(map_.chain)


def _fixed_points(map_: PiecewiseLinearMap, order: int) -> Row:
    written, own = _map(map_, None)
    iterate = map_.iterate(order)
    bands = {band.word for band in iterate.fixed_intervals()}
    return {
        "kind": certificate.FIXED_POINTS,
        "map": written,
        "order": own * order,
        "fixed points": [
            {"word": p.word, "x": _rational(p.x), "slope": _rational(p.multiplier),
             "period": p.period, "stable": p.stable}
            for p in iterate.fixed_points()
        ],
        "intervals": [
            {"word": piece.word, "ends": [_rational(piece.lower), _rational(piece.upper)],
             "closed": [piece.lower_closed, piece.upper_closed]}
            for piece in iterate.pieces
            if piece.word in bands
        ],
        "crossings": [
            {"word": f"{c.left_word}|{c.right_word}", "x": _rational(c.x),
             "left": _rational(c.left), "right": _rational(c.right)}
            for c in iterate.jump_crossings()
        ],
    }  # fmt: skip


# --- Diagrams -------------------------------------------------------------------------------------


def _closed(map_: Map, edges: Iterable[Real], orders: Sequence[int]) -> list[Real]:
    """Edges, refined until no deciding polynomial has a root strictly between two of them."""
    found = sorted(set(edges))
    cells = list(pairwise(found))
    while cells:
        low, high = cells.pop()
        sample = Fraction(*pair(simplest_between(low, high)))
        here = CheckedNumber((), sample, sample)
        place = Place(here, here, Effort())
        for order in orders:
            parts = CheckedIterate(map_._replace(work=place.work), place, order)
            _ = parts.fixed, parts.bands, parts.crossings
        roots = {x for poly in place.signs for x in real_roots([QQ(c) for c in reversed(poly)])}
        inner = sorted(x for x in roots if low < x < high)
        if inner:
            cells += pairwise([low, *inner, high])
            found += inner
    return sorted(found)


def _number(x: Real, below: Real = LOWEST, above: Real = HIGHEST) -> str | Row:
    """A number for the checker, with an interval free of its neighbours and conjugates."""
    if not isinstance(x, RealRoot):
        return _text(x)
    same = real_roots(x.polynomial)
    low = max(each for each in (*same, below) if each < x)
    high = min(each for each in (*same, above) if x < each)
    ends = simplest_between(low, x), simplest_between(x, high)
    poly = [str(c) for c in reversed(integers(x.polynomial))]
    return {"polynomial": poly, "interval": [_text(end) for end in ends]}


def _image(root: RealRoot, top: Dense, bottom: Dense) -> Real:
    """The value of a quotient of polynomials at a root, as a root of its own polynomial."""
    value = Element(root, root.quotient(top, bottom))
    if len(value.value) < 2:
        return value.value[0] if value else QQ.zero
    size = len(root.polynomial) - 1
    rows = [root.reduced((*value.value, *[QQ.zero] * i)) for i in reversed(range(size))]
    matrix = DomainMatrix(
        [[QQ.zero] * (size - len(row)) + list(row) for row in rows], (size, size), QQ
    )
    candidates = real_roots(matrix.charpoly())
    return candidates[sum(value > simplest_between(*pair) for pair in pairwise(candidates))]


def _at_edge(row: Row, read: branches.ClaimedDiagram, place: int) -> Row:
    """A row of fixed points at an edge, with the checker's slope and stability there."""
    there = read.found(place, row["order"])["fixed points"].get(row["word"])
    if there is None:  # left as it is: the checker will refuse it with its own sentence
        return row
    slope, known = row["slope"], there.quotients["slope"]
    if known is None:
        slope = None
    elif slope is None:
        slope = [[str(c) for c in part] for part in known]
    return row | {"slope": slope, "stable": there.stable}


def _runs(rows: Mapping[int, Row]) -> list[list[int]]:
    """Runs of successive places at which rows agree on having a slope and on stability."""

    def said(each: tuple[int, int]) -> tuple[object, ...]:
        row = rows[each[1]]
        return each[1] - each[0], row.get("slope") is None, row.get("stable")

    return [[place for _, place in run] for _, run in groupby(enumerate(sorted(rows)), key=said)]


class _DiagramWriter:
    def __init__(
        self, diagram: Diagram, map_: PiecewiseLinearMap, orders: Iterable[int] | None
    ) -> None:
        self._diagram = diagram
        self._map, self._own = _map(map_, diagram.parameter_name)
        self._symbol = map_.parameters[0]
        if self._own > 1:
            _fail("the diagram of an iterate, only that of the map itself is")
        # bands are not certified: their order is the number of bands
        followed = [each for each in diagram.branches if each.kind is not BranchKind.BAND]
        found = {each.order for each in followed} or {1} if orders is None else orders
        self._orders = [*with_divisors(checked_orders(found))]
        has = diagram.about.get("orders", self._orders)
        if isinstance(has, list) and not set(has).issuperset(self._orders):
            _fail(f"the diagram must have the orders {self._orders}, it has {shown(has)}")
        own = [
            (branch, stretch)
            for branch in followed
            if branch.order in self._orders
            for stretch in branch.words
        ]
        if any("interval" not in stretch.exact for _, stretch in own):
            _fail("a diagram without exact values")
        self._stretches = [each for each in own if self._is_followed(each[1])]
        ends = {end for _, stretch in own for end in self._ends(stretch)}
        if len(ends) < 2:
            _fail("the diagram has no branch over an interval of the parameter")
        map_read = read_map(self._map, Effort(), parametric=True)[0]
        self._edges = _closed(map_read, ends, self._orders)
        self._index = {edge: i for i, edge in enumerate(self._edges)}

    def content(self) -> Row:
        around = zip([LOWEST, *self._edges], self._edges, [*self._edges[1:], HIGHEST], strict=False)
        found: Row = {
            "kind": certificate.DIAGRAM,
            "map": self._map,
            "orders": self._orders,
            "edges": [_number(edge, below, above) for below, edge, above in around],
            "fixed points": [],
            "intervals": [],
            "crossings": [],
            "points": [],
        }
        try:
            read = branches.ClaimedDiagram(found)
            for kind, row in self._followed(read):
                found[kind].append(row)
            read = branches.ClaimedDiagram(found)
            found["points"] = [
                row
                for point in self._diagram.points
                if point.kind in CERTIFIED
                for row in self._point(point, read)
            ]
        except Refused as error:
            _fail(str(error))
        return found

    def _followed(self, read: branches.ClaimedDiagram) -> Iterator[tuple[str, Row]]:
        """Yield kind and row: stretches of a word, joined, cut where slope or stability change."""
        # Intervals of fixed points, of which diagrams have only the ends, come from the checker.
        found: dict[tuple[str, int, str], dict[int, Row]] = {}
        for order, place in product(self._orders, range(1, read.last)):
            for word in read.found(place, order)["intervals"]:
                rows = found.setdefault(("intervals", order, word), {})
                rows[place] = {"order": order, "word": word}
        for branch, stretch in self._stretches:
            kind = "fixed points" if branch.kind is BranchKind.FIXED_POINT else "crossings"
            row = self._row(branch, stretch)
            first, last = row["places"]
            rows = found.setdefault((kind, row["order"], row["word"]), {})
            for place in range(first, last + 1):
                is_end = place % 2 == 0 and first < last and kind == "fixed points"
                rows[place] = _at_edge(row, read, place) if is_end else row
        for (kind, _, _), rows in found.items():
            for run in _runs(rows):
                inside = next((place for place in run if place % 2), run[0])
                yield kind, rows[inside] | {"places": [run[0], run[-1]]}

    def _is_followed(self, stretch: Stretch) -> bool:
        """Whether a stretch is neither an interval of fixed points nor an end of one."""
        return "x" in stretch.exact and stretch.exact.get("multiplier") != 1

    def _ends(self, stretch: Stretch) -> tuple[Real, Real]:
        interval: Any = stretch.exact["interval"]  # or a one-point set
        if interval.inf.is_infinite or interval.sup.is_infinite:
            _fail(f"the branch {stretch.word} goes on without end")
        return algebraic(interval.inf), algebraic(interval.sup)

    def _places(self, stretch: Stretch) -> list[int]:
        interval: Any = stretch.exact["interval"]
        first, last = (2 * self._index[end] for end in self._ends(stretch))
        return [first + (interval.inf not in interval), last - (interval.sup not in interval)]

    def _row(self, branch: Branch, stretch: Stretch) -> Row:
        exact: Mapping[str, Any] = stretch.exact
        row: Row = {
            "order": branch.order,
            "word": stretch.word,
            "places": self._places(stretch),
            "x": self._quotient(exact["x"]),
        }
        if branch.kind is BranchKind.JUMP:
            return row | {side: self._quotient(exact[side]) for side in ("left", "right")}
        slope = exact["multiplier"]
        stable = branch.attracts
        if stable is None:
            low, high = self._ends(stretch)
            at = low if low == high else simplest_between(low, high)
            signs = [sign_at(part, at) for part in self._parts(slope**2 - 1)]
            stable = signs[0] * signs[1] < 0
        is_nan = slope is sympy.nan
        return row | {"slope": None if is_nan else self._quotient(slope), "stable": stable}

    def _parts(self, expr: sympy.Expr) -> tuple[Dense, Dense]:
        return quotient_in(expr, self._symbol)

    def _quotient(self, expr: sympy.Expr) -> list[list[str]]:
        return [[_text(c) for c in reversed(part)] for part in self._parts(expr)]

    def _point(self, point: SpecialPoint, read: branches.ClaimedDiagram) -> Iterator[Row]:
        """Yield the row of a special point if fixed points end there."""
        parameter = algebraic(point.exact["parameter"])
        i = self._index.get(parameter, 0)
        at = self._x(point, parameter) if 0 < i < len(self._edges) - 1 else None
        if at is None:
            return
        side = {"oo": 1, "-oo": -1}.get(at) if isinstance(at, str) else None
        place = side if side is not None else number(at, Effort())
        ends = [end for end in read.ends(i) if read.is_at(end, i, place)]
        if not points.is_special(ends):
            return
        found = points.Point(read, i, ends, infinite=side is not None).claims()
        if not self._meets_interval(point):  # whose ends only the diagram has as branches
            found |= {"code": str(point.kind), "note": point.note}
        yield {"edge": i, "x": at, **found}

    def _meets_interval(self, point: SpecialPoint) -> bool:
        """Whether a branch at the point is an end of a persistent interval of fixed points."""
        return any(
            stretch.exact.get("multiplier") == 1 and "x" in stretch.exact
            for name in point.branches
            for stretch in self._diagram.branch(name).words
        )

    def _x(self, point: SpecialPoint, parameter: Real) -> str | Row | None:
        """The x of a special point; None if no fixed points end there."""
        formulas = (
            stretch.exact["x"]
            for branch, stretch in self._stretches
            if branch.kind is BranchKind.FIXED_POINT and branch.id in point.branches
            if parameter in self._ends(stretch)
        )
        formula, x = next(formulas, None), point.exact["x"]
        if formula is None or x in (sympy.oo, -sympy.oo):
            return None if formula is None else str(x)
        if not isinstance(parameter, RealRoot):
            return _number(algebraic(x))
        return _number(_image(parameter, *self._parts(formula)))
