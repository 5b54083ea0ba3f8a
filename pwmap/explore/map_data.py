"""The exact answers that a page shows, part by part, and its files, made in another process."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np
import sympy
from sympy import QQ, Rational

from pwmap import (
    Budget,
    Diagram,
    FixedPoint,
    ParameterCell,
    ParameterCells,
    PiecewiseLinearMap,
    bifurcation_diagram,
    cycles,
    dynamics,
    parameter_cells,
    parameter_plane,
)
from pwmap.algebra.assumptions import UndecidedError
from pwmap.algebra.roots import algebraic, simplest_between
from pwmap.diagrams.files import table_as_text
from pwmap.explore.diagrams import NOTHING, shown, table
from pwmap.explore.exports import Files, made, of_all_pages, pictures
from pwmap.explore.figures import Rows, Shown, along, judged
from pwmap.explore.map_state import PLANE_ORDERS, MapState, from_query, rational
from pwmap.longrun.cycles import FoundCycle, FoundCycles
from pwmap.plane.plane import ParameterPlane
from pwmap.plane.rasters import arc_arrays
from pwmap.plot import plot_cobweb, plot_density, plot_plane
from pwmap.plot.diagrams import INK, around, pieces_within
from pwmap.plot.drawn import stairs, strokes
from pwmap.plot.palette import LINES

BUDGET = Budget(pieces=30_000, work=8_000_000)
PERIODS = 6  # longest period of cycles that are listed
ROWS = 60  # of a table
TEXT = 160  # characters of an exact value
LETTERS = 24  # of a word
SAMPLES = 160  # along a curve across the plane
SIGNS = 12  # most signs that are assumed to be those at the values of a page
SECONDS = 40.0  # s for all answers about a map
CURVES = ("xs", "ys", "color", "dash", "name", "tip")  # of the plane


@lru_cache(maxsize=1)
def family_of(state: MapState) -> PiecewiseLinearMap:
    """The map with its parameters as symbols; ValueError if the text is no such map."""
    given = [part.strip() for part in state.given.split(";") if part.strip()]
    family = PiecewiseLinearMap.from_sympy(state.map, "x", given)
    unknown = {str(symbol) for symbol in family.parameters} - set(state.parameters)
    if unknown:
        raise ValueError(f"too many parameters: {', '.join(sorted(unknown))}")
    return family


def completed(state: MapState) -> MapState:
    """The state with the assumptions that its map needs: signs of polynomials, as at its values.

    Intervals that cross a zero of such a polynomial end there. ValueError if it is zero at these
    values.
    """
    for _ in range(SIGNS):
        try:
            family_of(state)
        except UndecidedError as error:
            if error.polynomial is None:
                raise
            state = _with_sign(state, error.polynomial)
        else:
            return state
    raise ValueError(f"more than {SIGNS} signs do not follow from what is assumed: assume more")


def _with_sign(state: MapState, polynomial: sympy.Expr) -> MapState:
    """The state with the assumption that a polynomial keeps the sign that it has at its values."""
    place = {symbol: Rational(state.place[symbol.name]) for symbol in polynomial.free_symbols}
    factors = [each for each, _ in sympy.factor_list(polynomial)[1]]
    signed = []
    for each in factors:
        value = each.subs(place)
        if value == 0:
            where = ", ".join(f"{symbol} = {place[symbol]}" for symbol in sorted(place, key=str))
            raise ValueError(f"{each} must have a sign and is zero at {where}: give other values")
        signed.append(f"{each} {'>' if value > 0 else '<'} 0")
    spans: dict[str, Any] = {"span": _clipped(state, factors, state.axis, state.span)}
    for name, axis in zip(state.plane_names, ("across", "along"), strict=False):
        spans[axis] = _clipped(state, factors, name, getattr(state, axis))
    given = "; ".join(filter(None, (state.given.strip(), *signed)))
    return replace(state, given=given, **spans)


def _clipped(
    state: MapState, factors: list[sympy.Expr], name: str, span: tuple[str, str]
) -> tuple[str, str]:
    """The part of a span around the value of a parameter in which no factor vanishes."""
    low, high = map(Rational, span)
    value = Rational(state.place[name])
    for factor in factors:
        others = {s: Rational(state.place[s.name]) for s in factor.free_symbols if s.name != name}
        for root in sympy.Poly(factor.subs(others), sympy.Symbol(name)).real_roots():
            end = root
            if not root.is_Rational:
                between = simplest_between(*sorted((algebraic(root), QQ.from_sympy(value))))
                end = QQ.to_sympy(between)
            low, high = (max(low, end), high) if root < value else (low, min(high, end))
    return str(low), str(high)


def held(state: MapState, *free: str) -> PiecewiseLinearMap:
    """The map with values for all but the ``free`` parameters; ValueError if it refuses them."""
    family = family_of(state)
    rest = {n: state.place[n] for n in map(str, family.parameters) if n not in free}
    return family.at(rest) if rest else family


def answers(state: MapState) -> Iterator[Shown]:
    """Everything that a page shows of a map, the quick answers first."""
    held(state)  # raises at once if the map itself is wrong
    for name, answer in (
        ("map", _map), ("cells", _cells), ("diagram", _diagram), ("long", _long), ("plane", _plane),
    ):  # fmt: skip
        try:
            yield answer(state)
        except (ValueError, ArithmeticError) as error:  # the other answers may succeed
            nothing = NOTHING if name == "diagram" else Shown(name=name)
            yield replace(nothing, message=str(error)[:400])


# --- The map --------------------------------------------------------------------------------------


def _map(state: MapState) -> Shown:
    here = held(state)
    iterate = here.iterate(state.order)
    pieces, fixed, jumps = iterate.pieces, iterate.fixed_points(), iterate.jump_crossings()
    web, found = orbit(iterate, state), cycles_here(here)
    points = [float(p.x) for p in fixed]
    marks = [*points, *(float(v) for j in jumps for v in (j.x, j.left, j.right)), *map(float, web)]
    marks += [float(piece.lower) for piece in pieces[1:]]
    low, high = around(marks)
    lines = [[(float(j.x), float(j.left)), (float(j.x), float(j.right))] for j in jumps]
    crossings = np.array(lines).reshape(-1, 2, 2)
    tables = {
        **_graph(iterate, low, high), "web": along(stairs([float(x) for x in web])),
        "crossings": along(strokes(crossings[:, :, 0], crossings[:, :, 1])),
        "fixed": {"x": points, "y": points, "word": [p.word for p in fixed],
                  "exact": [_text(p.x) for p in fixed], **judged(bool(p.stable) for p in fixed)},
    }  # fmt: skip
    rows = {
        f"Pieces of P{_low(state.order)}": [
            [_word(p.word), _text(p.expression), p.condition()] for p in pieces
        ],
        "Jump crossings": [
            [f"x = {_text(j.x)}", f"from {_text(j.left)}", f"to {_text(j.right)}"] for j in jumps
        ],
        f"Cycles up to period {PERIODS}": _cycle_rows(family_of(state), found),
        "Orbit": [[str(k), _text(x)] for k, x in enumerate(web)],
    }
    return Shown(
        name="map", tables=tables, ends={"map": (low, high, low, high)},
        labels={"map": ("x", rf"$$P_{{{state.order}}}(x)$$")}, rows=_first(rows),
        message=found.left_out,
    )  # fmt: skip


def orbit(iterate: PiecewiseLinearMap, state: MapState) -> list[Fraction]:
    """The points of the cobweb, up to the first number that is too long."""
    found = [Fraction(state.start)]
    for _ in range(state.steps):
        value = iterate(found[-1])
        found.append(Fraction(int(value.p), int(value.q)))
        if len(str(found[-1])) > TEXT:  # an orbit that never closes gains digits at each step
            break
    return found


def cycles_here(here: PiecewiseLinearMap) -> FoundCycles:
    """All cycles up to the longest period that a page lists."""
    return cycles(here, {}, PERIODS, budget=BUDGET)


def _graph(iterate: PiecewiseLinearMap, low: float, high: float) -> dict[str, dict[str, Any]]:
    lines, ends = pieces_within(iterate, (low, high))
    places = [(x, y) for line in lines for x, y in (*line, (np.nan, np.nan))]
    filled = [(x, y, INK if closed else "white") for x, y, closed in ends]
    return {"curve": table(("x", "y"), places), "ends": table(("x", "y", "fill"), filled)}


def _cycle_rows(family: PiecewiseLinearMap, found: FoundCycles) -> Rows:
    """Rows of word, exact points and multiplier; then the formula and conditions in parameters."""
    rows: Rows = []
    for cycle in found:
        formula, border = "", ""
        if family.parameters and len(rows) < ROWS:
            try:
                known = family.cycle(cycle.word)
                formula = f"x = {_text(known.points[0])}"
                border = "; ".join(map(_text, known.conditions))
            except (ValueError, ArithmeticError) as error:
                formula = str(error)[:TEXT]
        points = ", ".join(map(_text, cycle.points))
        rows.append([_word(cycle.word), points, _kind(cycle), formula, border])
    return rows


def _kind(cycle: FoundCycle) -> str:
    if cycle.multiplier is None:
        return "on a break"
    told = "attracts" if cycle.stable else "repels" if abs(cycle.multiplier) > 1 else "neutral"
    return f"{'on a break' if cycle.at_break else told}, {_text(cycle.multiplier)}"


# --- Over one parameter ---------------------------------------------------------------------------


def _line(state: MapState) -> PiecewiseLinearMap:
    if not state.axis:
        raise ValueError("the map has no parameter, so there is no diagram of it")
    return held(state, state.axis)


def cells(state: MapState) -> ParameterCells:
    """The cells of the diagram's parameter; ValueError if the map has none."""
    line = _line(state)
    return parameter_cells(line, state.axis, state.all_orders, span=state.span, budget=BUDGET)


def points_of(cell: ParameterCell, state: MapState) -> Iterator[FixedPoint]:
    """The points of all cycles in a cell whose periods are orders of the diagram."""
    for order in state.all_orders:
        yield from (p for p in cell.map.iterate(order).fixed_points() if p.period == order)


def whole_diagram(state: MapState) -> Diagram:
    """The diagram over one parameter; ValueError if the map has none."""
    line = _line(state)
    return bifurcation_diagram(line, state.axis, state.span, state.all_orders, budget=BUDGET)


def _cells(state: MapState) -> Shown:
    if not state.axis:
        return Shown(name="cells")
    found = cells(state)
    value = Rational(state.place[state.axis])
    rows: Rows = []
    for cell in found:
        inside = cell.lower == value if cell.is_edge else cell.lower < value < cell.upper
        where = (
            f"{state.axis} = {_text(cell.lower)}"
            if cell.is_edge
            else f"{_text(cell.lower)} < {state.axis} < {_text(cell.upper)}"
        )
        points = [f"{_word(p.word)}: {_text(p.x)}" for p in points_of(cell, state)]
        rows.append([where + (" ← here" if inside else ""), "; ".join(points) or "no cycle"])
    return Shown(name="cells", rows=_first({f"Cells of {state.axis}": rows}))


def _diagram(state: MapState) -> Shown:
    if not state.axis:
        return NOTHING
    found = whole_diagram(state)
    rows = [
        [f"{p.kind} {p.note}", f"{state.axis} = {_text(p.exact.get('parameter', p.parameter))}",
         f"x = {_text(p.exact.get('x', p.x))}"]
        for p in found.points if str(p.kind) != "EP"
    ]  # fmt: skip
    return replace(shown(found), rows=_first({"Special points": rows}))


# --- The long run, and two parameters -------------------------------------------------------------


def _long(state: MapState) -> Shown:
    found = dynamics(held(state), budget=BUDGET)
    entropy = found.entropy
    exact = f"= {_text(entropy.value)}" if entropy.value is not None else ""
    rows: dict[str, Rows] = {
        "Attractors": [[str(each)[:TEXT], _exponent(each)] for each in found.attractors],
        "Entropy": [[f"in [{entropy.low:.12g}, {entropy.high:.12g}]", exact]],
    }
    steps = [
        tuple(map(float, step))
        for attractor in found.attractors if attractor.density is not None
        for step in attractor.density.steps()
    ]  # fmt: skip
    tables = {"steps": table(("left", "right", "top"), steps)}
    left, right, top = tables["steps"].values()
    ends = {"density": (left[0], right[-1], 0.0, 1.08 * max(top))} if steps else {}
    return Shown(name="long", tables=tables, ends=ends, rows=rows)


def _exponent(attractor: Any) -> str:
    exact = attractor.exponent
    if exact is not None:
        return f"Lyapunov exponent {_text(exact)}"
    bounds = attractor.exponent_bounds
    return "" if bounds is None else f"Lyapunov exponent in [{bounds[0]:.6g}, {bounds[1]:.6g}]"


def plane(state: MapState) -> ParameterPlane:
    """The plane of two parameters; ValueError if the map has fewer."""
    names = state.plane_names
    if not names:
        raise ValueError("a plane needs a map with two parameters")
    flat = held(state, *names)
    return parameter_plane(
        flat, names[0], names[1], state.across, state.along, PLANE_ORDERS, budget=BUDGET
    )


def _plane(state: MapState) -> Shown:
    if not state.plane_names:
        tables = {"curves": table(CURVES, ()), "meeting": table(("x", "y"), ())}
        return Shown(name="plane", tables=tables, labels={"plane": ("", "")})
    found = plane(state)
    low, high = map(Fraction, state.across)
    lines, rows = [], []
    for curve in found.curves:
        style, kind = LINES[curve.kind], curve.kind.label
        words, zero = ", ".join(map(_word, curve.words)), f"{_text(curve.polynomial)} = 0"
        rows.append([curve.id, kind, words, zero])
        dash = [5, 3] if style.get("linestyle") == "--" else []
        for arc in curve.arcs:
            x, y = arc_arrays(arc, float(high - low) / SAMPLES)
            lines.append((x, y, style["color"], dash, curve.id, f"{kind} of {words}: {zero}"))
    nodes = [[float(v) for v in point.values] for point in found.points]
    meeting = [
        [p.id, p.kind.label, ", ".join(map(_text, p.values)), " ".join(p.curves)]
        for p in found.points
    ]
    tables = {"curves": table(CURVES, lines), "meeting": table(("x", "y"), nodes)}
    told = {"Curves of the plane": rows, "Points of codimension two": meeting}
    ends = tuple(float(rational(each)) for each in (*state.across, *state.along))
    return Shown(
        name="plane", tables=tables, ends={"plane": ends}, rows=_first(told),
        labels={"plane": state.plane_names}, message=found.left_out,
    )  # fmt: skip


# --- Texts ----------------------------------------------------------------------------------------


def _first(tables: dict[str, Rows]) -> dict[str, Rows]:
    return {
        title: rows if len(rows) <= ROWS else [*rows[:ROWS], [f"and {len(rows) - ROWS} more"]]
        for title, rows in tables.items()
    }


def _text(value: object) -> str:
    told = re.sub(r"\boo\b", "∞", str(value))
    return told if len(told) <= TEXT else f"{told[:TEXT]}… ({len(told)} characters)"


def _word(word: str) -> str:
    return word if len(word) <= LETTERS else f"{word[:LETTERS]}… ({len(word)} letters)"


def _low(number: int) -> str:
    return "".join("₀₁₂₃₄₅₆₇₈₉"[int(digit)] for digit in str(number))


# --- Files ----------------------------------------------------------------------------------------


def _iterate(state: MapState) -> PiecewiseLinearMap:
    return held(state).iterate(state.order)


def _pieces_table(state: MapState) -> str:
    rows = [
        (p.word, p.lower, int(p.lower_closed), p.upper, int(p.upper_closed), p.slope, p.intercept)
        for p in _iterate(state).pieces
    ]
    header = ("word", "lower", "lower_closed", "upper", "upper_closed", "slope", "intercept")
    return table_as_text(header, rows)


def _cycles_table(state: MapState) -> str:
    found = cycles_here(held(state))
    if found.left_out:
        raise ValueError(f"the cycles are not complete: {found.left_out}")
    rows = [
        (c.word, len(c.points), c.multiplier, c.stable, "; ".join(map(str, c.points)))
        for c in found
    ]
    return table_as_text(("word", "period", "multiplier", "stable", "points"), rows)


def _orbit_table(state: MapState) -> str:
    return table_as_text(("step", "x"), list(enumerate(orbit(_iterate(state), state))))


def _cells_table(state: MapState) -> str:
    rows = [
        (cell.lower, cell.upper, point.period, point.word, point.x)
        for cell in cells(state) for point in points_of(cell, state)
    ]  # fmt: skip
    return table_as_text(("lower", "upper", "period", "word", "x"), rows)


FILES: Files = {
    **pictures("map", lambda state: plot_cobweb(_iterate(state), state.start, state.steps)),
    **pictures("plane", lambda state: plot_plane(plane(state))),
    **pictures("density", lambda state: plot_density(dynamics(held(state), budget=BUDGET))),
    "pieces.csv": ("pieces of the iterate (CSV)", _pieces_table),
    "cycles.csv": ("cycles (CSV)", _cycles_table),
    "orbit.csv": ("the orbit (CSV)", _orbit_table),
    "cells.csv": ("cells of the parameter (CSV)", _cells_table),
    **of_all_pages(whole_diagram),
}


def export(name: str, query: str) -> Iterator[tuple[str, bytes]]:
    """A job that makes a file of :data:`FILES` from a state; ValueError for another name."""
    yield from made(name, from_query(query), FILES)
