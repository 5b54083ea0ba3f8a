"""Cells of a parameter and compositions: every piece and what lies on the diagonal."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import pairwise
from typing import Any

import sympy
from comparisons import Report
from families import Family
from independent import (
    Number,
    band_period,
    crossings,
    fixed_points,
    iterated,
    nested,
    refined,
)
from readings import Place, between, compared, evaluated, number_of, place

from pwmap import ParameterCell, parameter_cells


def check_cells(family: Family, report: Report, draw: random.Random) -> None:
    """The formulas of all cells, at a random parameter inside each and on each edge."""
    cells = parameter_cells(family.map(), "p", family.orders, family.span)
    seen = []
    for cell in cells:
        lower, upper = place(cell.lower), place(cell.upper)
        if cell.is_edge:
            p: Place = lower
        else:
            first = between(lower, upper)
            p = draw.choice([first, between(lower, first), between(first, upper)])
        seen.append(_check_cell(family, cell, p, report))
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


def _check_cell(family: Family, cell: ParameterCell, p: Place, report: Report) -> list[Any]:
    at = number_of(p)
    iterates = iterated(family.at(at), max(family.orders))
    seen: list[Any] = []
    for order in family.orders:
        parts, map_ = iterates[order - 1], cell.map.iterate(order)
        truth: list[Any] = [
            (q.lo, q.lo_in, q.hi, q.hi_in, *_formula(q.slope, q.intercept, q.lo, q.hi), q.word)
            for q in parts
        ]
        found: list[Any] = []
        for piece in map_.pieces:
            lo, hi = evaluated(piece.lower, at), evaluated(piece.upper, at)
            formula = _formula(evaluated(piece.slope, at), evaluated(piece.intercept, at), lo, hi)
            found.append((lo, piece.lower_closed, hi, piece.upper_closed, *formula, piece.word))
        where = f"cell ({cell.lower}, {cell.upper}), order {order}, p = {p}"
        _same(report, "pieces of cells", found, truth, where)
        points = list(fixed_points(iterates[0], parts, order))
        truth = [(f.x, f.word, f.multiplier, f.period, f.stable, f.at_border) for f in points]
        found = [
            (
                evaluated(f.x, at),
                f.word,
                evaluated(f.multiplier, at),
                f.period,
                f.stable,
                f.at_border,
            )
            for f in map_.fixed_points()
        ]
        _same(report, "fixed points of cells", found, truth, where)
        jumps = list(crossings(parts))
        truth = [(c.x, c.left, c.right, c.words) for c in jumps]
        found = [
            (
                *(evaluated(v, at) for v in (c.x, c.left, c.right)),
                f"{c.left_word}|{c.right_word}",
            )
            for c in map_.jump_crossings()
        ]
        _same(report, "crossings of cells", found, truth, where)
        bands = [q for q in parts if q.is_identity]
        truth = [(q.lo, q.hi, q.word, band_period(iterates[0], q, order)) for q in bands]
        found = [
            (
                evaluated(band.interval.start, at),
                evaluated(band.interval.end, at),
                band.word,
                band.period,
            )
            for band in map_.fixed_intervals()
        ]
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


def _formula(slope: Number, intercept: Number, lo: Number, hi: Number) -> tuple[Number, Number]:
    """Of a piece that is a point only the value counts."""
    if lo is not None and hi is not None and lo == hi:
        return None, slope * lo + intercept
    return slope, intercept


def _same(report: Report, subject: str, found: list[Any], truth: list[Any], where: str) -> None:
    report.compared[subject] += len(truth)
    if found != truth:
        report.check(subject, False, lambda: f"{where}:\n  found {found}\n  truth {truth}")


def check_nested(family: Family, report: Report, draw: random.Random) -> None:
    """The brute force itself, and iterates of the package, against nested evaluation."""
    p = family.span[0] + (family.span[1] - family.span[0]) * Fraction(draw.randrange(1, 97), 97)
    base = family.at(p)
    order = max(family.orders)
    iterate = family.map().at({"p": sympy.Rational(p.numerator, p.denominator)}).iterate(order)
    parts = iterated(base, order)[-1]
    ends = [q.lo for q in parts if q.lo is not None]
    for x in (*ends, *(Fraction(draw.randint(-60, 60), 7) for _ in range(10))):
        truth = nested(base, x, order)
        (part,) = [q for q in parts if q.holds(x)]
        assert (part(x), part.word) == truth
        at = sympy.Rational(x.numerator, x.denominator)
        pieces = [piece for piece in iterate.pieces if piece.interval.contains(at) == sympy.true]
        exact = sympy.Rational(truth[0].numerator, truth[0].denominator)
        good = len(pieces) == 1 and (
            pieces[0].slope * at + pieces[0].intercept == exact == iterate(at)
            and pieces[0].word == truth[1] == iterate.word_of(at)
        )
        report.check("nested evaluation", good, lambda x=x: f"order {order}, p = {p}, x = {x}")


def compare_composition(first: Family, second: Family, seed: int, report: Report) -> None:
    """Pieces of the second map after the first, at a random parameter."""
    p = Fraction(random.Random(seed).randint(-20, 20), 21)
    at = {"p": sympy.Rational(p.numerator, p.denominator)}
    truth = [
        (q.lo, q.lo_in, q.hi, q.hi_in, *_formula(q.slope, q.intercept, q.lo, q.hi), q.word)
        for q in refined(first.at(p), second.at(p))
    ]
    found = []
    for piece in (second.map().at(at) @ first.map().at(at)).pieces:
        lo, hi = evaluated(piece.lower, p), evaluated(piece.upper, p)
        formula = _formula(evaluated(piece.slope, p), evaluated(piece.intercept, p), lo, hi)
        found.append((lo, piece.lower_closed, hi, piece.upper_closed, *formula, piece.word))
    _same(report, "compositions", found, truth, f"{second} after {first} at {p}")
