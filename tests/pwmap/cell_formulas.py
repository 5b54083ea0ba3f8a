"""Cells of a parameter and compositions: every piece and what lies on the diagonal."""

import random
from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import pairwise
from operator import attrgetter
from typing import Any

import sympy
from comparisons import Report
from families import Family
from independent import (
    Number,
    Parts,
    band_period,
    crossings,
    fixed_points,
    iterated,
    refined,
)
from readings import Place, between, compared, evaluated, number_of, place

from pwmap import PiecewiseLinearMap, parameter_cells

OF_PIECE = attrgetter(
    "lower", "lower_closed", "upper", "upper_closed", "slope", "intercept", "word"
)  # fmt: skip
OF_PART = attrgetter("lo", "lo_in", "hi", "hi_in", "slope", "intercept", "word")
OF_POINT = attrgetter("x", "word", "multiplier", "period", "stable", "at_border")
SAMPLES = 20  # of the parameter, for edges that were missed


def check_cells(family: Family, report: Report, draw: random.Random) -> None:
    """The formulas of all cells, at a random parameter inside each, on each edge and elsewhere.

    On edges that are rational the map with the number put for its parameter is compared as well.
    """
    cells = parameter_cells(family.map(), "p", family.orders, family.span)
    seen = []
    for cell in cells:
        lower, upper = place(cell.lower), place(cell.upper)
        if cell.is_edge:
            p: Place = lower
        else:
            first = between(lower, upper)
            p = draw.choice([first, between(lower, first), between(first, upper)])
        seen.append(check_formulas(family, cell.map, p, family.orders, report))
        if cell.is_edge and cell.lower.is_Rational:
            there = family.map().at({"p": cell.lower})
            check_formulas(family, there, p, family.orders, report)
    ends = [(place(cell.lower), place(cell.upper)) for cell in cells]
    whole = ends[0][0] == family.span[0] and ends[-1][1] == family.span[1]
    report.check(
        "cells partition the span",
        whole and all(a[1] is b[0] or compared(a[1], b[0]) == 0 for a, b in pairwise(ends)),
        lambda: f"{ends}",
    )
    for i, cell in enumerate(cells):
        if cell.is_edge:
            report.check(
                "something changes at every edge",
                not seen[i - 1] == seen[i] == seen[i + 1],
                lambda c=cell: f"nothing changes at {c.lower}",
            )
    low, high = family.span
    for _ in range(SAMPLES):
        p = low + (high - low) * Fraction(draw.randrange(1, 9973), 9973)
        here = [c for c, (a, b) in zip(cells, ends, strict=True) if _lies(a, p, b)]
        report.check("one cell everywhere", len(here) == 1, lambda p=p: f"cells at {p}")
        check_formulas(family, here[0].map, p, family.orders, report)


def _lies(low: Place, p: Place, high: Place) -> bool:
    """Whether a parameter lies strictly between the ends of a cell, or is an edge."""
    left, right = compared(low, p), compared(p, high)
    return left < 0 > right or left == 0 == right


def check_formulas(
    family: Family, map_at: PiecewiseLinearMap, p: Place, orders: Sequence[int], report: Report
) -> list[Any]:
    """What a map says of its iterates, at a parameter; what brute force sees there."""
    at = number_of(p)
    iterates = iterated(family.at(at), max(orders))
    seen: list[Any] = []
    for order in orders:
        parts, map_ = iterates[order - 1], map_at.iterate(order)
        where = f"order {order}, p = {p}"
        _check_pieces(map_, parts, at, report, "pieces of cells", where)
        points, jumps = list(fixed_points(iterates[0], parts, order)), list(crossings(parts))
        truth = list(map(OF_POINT, points))
        found = evaluated_rows(map(OF_POINT, map_.fixed_points()), at)
        _same(report, "fixed points of cells", found, truth, where)
        truth = [(c.x, c.left, c.right, c.words) for c in jumps]
        found = evaluated_rows(
            (
                (c.x, c.left, c.right, f"{c.left_word}|{c.right_word}")
                for c in map_.jump_crossings()
            ),
            at,
        )
        _same(report, "crossings of cells", found, truth, where)
        bands = [q for q in parts if q.is_identity]
        truth = [
            (q.lo, q.lo_in, q.hi, q.hi_in, q.word, band_period(iterates[0], q, order))
            for q in bands
        ]
        intervals = [(band.interval, band) for band in map_.fixed_intervals()]
        found = evaluated_rows(
            ((i.start, not i.left_open, i.end, not i.right_open, band.word, band.period)
             for i, band in intervals), at,
        )  # fmt: skip
        _same(report, "bands of cells", found, truth, where)
        seen.append(
            (
                [(q.word, q.lo_in, q.hi_in, q.is_point) for q in parts],
                [(f.word, f.stable, f.at_border) for f in points],
                [c.words for c in jumps],
                [q.word for q in bands],
            )
        )
    return seen


def _check_pieces(
    map_: PiecewiseLinearMap, parts: Parts, at: Number, report: Report, subject: str, where: str
) -> None:
    """The pieces of a map at a parameter, and those of brute force there."""
    truth = list(map(_valued, map(OF_PART, parts)))
    found = list(map(_valued, evaluated_rows(map(OF_PIECE, map_.pieces), at)))
    _same(report, subject, found, truth, where)


def evaluated_rows(rows: Iterable[tuple[Any, ...]], at: Number) -> list[tuple[Any, ...]]:
    """Rows with numbers in place of their formulas."""
    return [
        tuple(evaluated(v, at) if isinstance(v, sympy.Basic) else v for v in row) for row in rows
    ]


def _valued(piece: tuple[Any, ...]) -> tuple[Any, ...]:
    """Of a piece that is a point only the value counts."""
    lo, lo_in, hi, hi_in, slope, intercept, word = piece
    if lo is not None and hi is not None and lo == hi:
        slope, intercept = None, slope * lo + intercept
    return lo, lo_in, hi, hi_in, slope, intercept, word


def _same(report: Report, subject: str, found: list[Any], truth: list[Any], where: str) -> None:
    report.compared[subject] += len(truth)
    if found != truth:
        report.check(subject, False, lambda: f"{where}:\n  found {found}\n  truth {truth}")


def compare_composition(first: Family, second: Family, seed: int, report: Report) -> None:
    """Pieces of the second map after the first, at a random parameter."""
    p = Fraction(random.Random(seed).randint(-20, 20), 21)
    at = {"p": sympy.Rational(p.numerator, p.denominator)}
    parts = refined(first.at(p), second.at(p))
    where = f"{second} after {first} at {p}"
    map_ = second.map().at(at) @ first.map().at(at)
    _check_pieces(map_, parts, p, report, "compositions", where)
