"""Pieces of a map at one parameter: borders and limits, and all cycles and jumps of iterates."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import pytest
from maps import (
    BORDER,
    A,
    Line,
    doubling,
    grazing,
    lines,
    lost_beyond,
    one_piece,
    paper,
    renamed_logistic,
    skew_tent,
    tent,
    two_lines,
)
from needs import NEEDS_NUMBA, SLOW_TOY

from woodpecker import (
    FormulaMap,
    FormulaPiece,
    PiecewiseMap,
    Smooth,
    Toy,
    ToyPieces,
    slices_at,
)
from woodpecker.base.settings import Settings
from woodpecker.maps import Iterate
from woodpecker.maps.pieces import Image
from woodpecker.slices import BorderKind, Slice, borders_in, crosses, nearest_border
from woodpecker.slices.partition import partition

NEAR = 1e-15  # a few roundings at 1
WIDE = Settings(window=(-3.0, 3.0))


def steps() -> FormulaMap:
    """Unit steps of x, each a piece of its own: n - 1 + p for n - 1 <= x < n, n = -1 .. 3."""
    return FormulaMap(
        [
            FormulaPiece(
                str(n),
                Line(0.0, 1.0, n).smooth(),
                {
                    f"x = {n}": Line(1.0, 0.0, -n).smooth(),
                    f"x = {n + 1}": Line(-1.0, 0.0, n + 1).smooth(),
                },
            )
            for n in range(-2, 3)
        ]
    )


def rising(*roots: float) -> FormulaMap:
    """x + the product of x - root: one piece with these fixed points."""

    def value(x: float, _p: float) -> float:
        return x + math.prod(x - root for root in roots)

    def slope(x: float, _p: float) -> float:
        gaps = [x - root for root in roots]
        return 1.0 + sum(math.prod(gaps[:k] + gaps[k + 1 :]) for k in range(len(gaps)))

    return one_piece(Smooth(value, slope, lambda x, p: 0.0))


# --- Borders --------------------------------------------------------------------------------------


@pytest.mark.parametrize("at", [0.3, -0.884773, 1.0, 1e-9, -2.9])
@pytest.mark.parametrize("offset", [-0.07, -1e-7, 1e-12, 0.05])
def test_a_border_is_found_to_the_last_bit(at: float, offset: float) -> None:
    """From whichever side it is looked for."""
    found = nearest_border(lines(Line(0.5, 1.0), Line(0.5, 1.0, 1.0), at=at), at + offset, 0.0, 0.1)
    assert found is not None
    assert found.x == pytest.approx(at, rel=2.0**-52)
    assert found.side == (1 if offset < 0.0 else -1)
    assert found.cause == BORDER


@pytest.mark.slow
def test_all_borders_of_a_window() -> None:
    found = borders_in(steps(), 0.25, (-1.5, 2.5))
    assert [border.x for border in found] == [-1.0, 0.0, 1.0, 2.0]
    for border in found:
        assert (border.inner.value, border.outer.value) == (border.x - 0.75, border.x + 0.25)
        assert (border.jump, border.kind(WIDE)) == (1.0, BorderKind.JUMP)
        assert (border.inner.piece.word, border.outer.piece.word) == (
            f"{border.x - 1:.0f}", f"{border.x:.0f}"
        )  # fmt: skip
        assert crosses(border)
    for p in (0.0, 1.0):  # one limit lies on the diagonal
        assert not any(map(crosses, borders_in(steps(), p, (-1.5, 2.5))))


@pytest.mark.parametrize(
    ("map_", "kind"),
    [
        (skew_tent(0.5, -1.5), BorderKind.KINK),
        (skew_tent(0.5, 0.5), BorderKind.SMOOTH),
        (renamed_logistic(0.0), BorderKind.SMOOTH),
        (grazing(-1.0), BorderKind.GRAZING),
        (grazing(30.0), BorderKind.GRAZING),
        (two_lines(), BorderKind.JUMP),
        (lines(Line(0.5, 1.0), Line(0.5, 1.0, 1e-7)), BorderKind.SMOOTH),  # below Settings.jump,
        (lines(Line(0.5, 1.0), Line(0.5, 1.0, 1e-5)), BorderKind.JUMP),  # a part of the window
        (lost_beyond(0.0), BorderKind.LOST),
    ],
)
def test_what_a_map_does_at_a_border(map_: PiecewiseMap, kind: BorderKind) -> None:
    found = nearest_border(map_, -0.05, 0.0, 0.1)
    assert found is not None
    assert found.kind(WIDE) is kind
    if kind is BorderKind.LOST:
        assert math.isnan(found.jump)
        assert found.inner.value == 0.0
    assert crosses(found) is False


@pytest.mark.parametrize(
    ("left", "right"),
    [(1e-6, 1e-3), (1e-3, 1e-6), (1e-12, 1e-2), (1e-2, 1e-12), (1e-6, 1.5e-6), (1.5e-6, 1e-6),
     (0.004, 0.005)],
)  # fmt: skip
def test_the_nearest_border_is_the_nearest(left: float, right: float) -> None:
    x, line = 0.5, Line(1.0, 0.0).smooth()
    low, high = x - left, x + right
    inside = {"low": Line(1.0, 0.0, -low).smooth(), "hi": Line(-1.0, 0.0, high).smooth()}
    map_ = FormulaMap(
        [
            FormulaPiece("A", line, {"low": Line(-1.0, 0.0, low).smooth()}),
            FormulaPiece("B", line, inside),
            FormulaPiece("C", line, {"hi": Line(1.0, 0.0, -high).smooth()}),
        ]
    )  # fmt: skip
    found = nearest_border(map_, x, 0.0, 0.02)
    assert found is not None
    assert (found.cause, found.side) == (("low", -1) if left < right else ("hi", 1))
    assert found.x == (low if left < right else high)
    assert found.inner.piece.word == "B"
    assert found.outer.piece.word == ("A" if left < right else "C")


def test_borders_of_the_second_iterate_of_the_paper() -> None:
    """At r = 1: P2^L jumps at r/a = 0.8 across the diagonal, at 0 only below it [Eq. 15]."""
    at_zero, preimage = borders_in(Iterate(paper(), 2), 1.0, (-3.0, 3.0))
    assert (at_zero.inner.value, at_zero.outer.value) == (-1.0, 1.0 - A)
    assert not crosses(at_zero)
    assert preimage.x == pytest.approx(0.8, abs=NEAR)
    assert (preimage.inner.value, preimage.outer.value) == pytest.approx((1.0, -1.0), abs=4 * NEAR)
    assert crosses(preimage)


# --- Where pieces accumulate ----------------------------------------------------------------------


@dataclass(frozen=True)
class Sevenths:
    """x/2 in infinitely many pieces that shrink towards zero: 7**-(n + 1) < x <= 7**-n."""

    def at(self, x: float, p: float) -> Image:
        if x <= 0.0:
            left = FormulaPiece("left", Line(0.0, 0.0, -1.0).smooth(),
                                {"zero": Line(-1.0, 0.0).smooth()})  # fmt: skip
            return left.at(x, p)
        n = math.floor(-math.log(x) / math.log(7.0))
        while x <= 7.0 ** -(n + 1):
            n += 1
        while x > 7.0**-n:
            n -= 1
        return FormulaPiece(
            str(n),
            Line(0.5, 0.0).smooth(),
            {
                f"7^-{n + 1}": Line(1.0, 0.0, -(7.0 ** -(n + 1))).smooth(),
                f"7^-{n}": Line(-1.0, 0.0, 7.0**-n).smooth(),
            },
        ).at(x, p)


@pytest.mark.parametrize("finest", [1e-4, 1e-6, 1e-9])
def test_infinitely_many_pieces_are_reported(finest: float) -> None:
    """All above the cut-off are found; what is left is about as long as it."""
    settings = Settings(window=(-0.5, 0.9), finest=finest)
    found = partition(Sevenths(), 0.0, settings.window, settings)
    words = {cylinder[0].image.piece.word for cylinder in found.cylinders}
    length, n = finest * settings.x_scale, 0
    while 7.0**-n - 7.0 ** -(n + 1) > length:
        assert str(n) in words
        n += 1
    assert n > 4
    assert 0.0 < found.unresolved <= length
    assert all(-NEAR <= low < high <= length for low, high in found.gaps)
    (shown,) = slices_at(Sevenths(), 0.0, (1,), settings)
    assert shown.unresolved == found.unresolved
    assert not shown.cycles


# --- Cycles ---------------------------------------------------------------------------------------


def shown(map_: PiecewiseMap, order: int, window: tuple[float, float] = (0.01, 0.99),
          p: float = 0.0) -> Slice:  # fmt: skip
    (found,) = slices_at(map_, p, (order,), Settings(window=window))
    return found


def fixed(found: Slice) -> list[float]:
    """Points of all cycles, ascending."""
    return sorted(float(x) for orbit in found.cycles for x in orbit.x)


@pytest.mark.parametrize("p", [0.3, 0.1, 1e-3, 1e-5])
def test_all_fixed_points_of_a_piece(p: float) -> None:
    """Also two that lie between neighbouring samples: zeros of P(x) - x at -1/2, 1/3, 1/3 + p."""
    roots = (-0.5, 1 / 3, 1 / 3 + p)
    rounding = 1e-15 / p  # P(x) - x has slope 5 p/6 at the zeros
    assert fixed(shown(rising(*roots), 1, (-1.0, 1.0))) == pytest.approx(roots, abs=rounding)


@pytest.mark.parametrize("roots", [(0.5, 0.502), (0.3, 0.5, 0.7), (0.3, 0.4, 0.6, 0.8)])
def test_fixed_points_are_no_cycles_of_an_iterate(roots: tuple[float, ...]) -> None:
    """They count for P_1 only; a rising map has no others."""
    assert fixed(shown(rising(*roots), 1, (0.1, 0.95))) == pytest.approx(roots, abs=1e-12)
    assert fixed(shown(rising(*roots), 2, (0.1, 0.95))) == []
    assert fixed(shown(rising(*roots), 3, (0.1, 0.95))) == []


def orbit(x: float, returns: int) -> list[float]:
    """Of the tent map."""
    points = [x]
    for _ in range(returns - 1):
        points.append(1.0 - abs(2.0 * points[-1] - 1.0))
    return points


@pytest.mark.parametrize("order", [1, 2, 3, 4, 6])
def test_every_cycle_of_the_tent_map(order: int) -> None:
    """k / (2**j -+ 1), those of minimal period j that stay in the window."""
    expected = set()
    for word in itertools.product((2.0, -2.0), repeat=order):
        slope, shift = 1.0, 0.0
        for s in word:  # x -> 2 x or 2 - 2 x
            slope, shift = s * slope, s * shift + (0.0 if s > 0.0 else 2.0)
        points = orbit(shift / (1.0 - slope), order)
        minimal = all(abs(points[d] - points[0]) > 1e-9 for d in range(1, order))
        if minimal and min(points) > 0.01 and max(points) < 0.99:
            expected.add(round(points[0], 12))
    found = shown(tent(), order)
    assert fixed(found) == pytest.approx(sorted(expected), abs=1e-12)
    for cycle in found.cycles:
        assert len(cycle) == order
        assert abs(cycle.multiplier) == 2.0**order
        assert cycle.x[0] == cycle.x.min()
    assert found.unresolved == 0.0


def test_a_flat_piece_has_its_cycle() -> None:
    """0.3 left of 1/2, 2 - 2 x right of it: 0.3 and 2/3 are fixed, and 0.3 is not reached."""
    map_ = lines(Line(0.0, 0.0, 0.3), Line(-2.0, 0.0, 2.0), at=0.5)
    found = shown(map_, 1)
    assert fixed(found) == pytest.approx([0.3, 2.0 / 3.0], abs=NEAR)
    assert sorted(cycle.multiplier for cycle in found.cycles) == [-2.0, 0.0]
    # 0.85 leads to 0.3 and stays: no cycle. 0.4 -> 0.85 -> 0.4 of this one is superstable
    other = lines(Line(0.0, 0.0, 0.8), Line(-2.0, 0.0, 2.0), at=0.5)
    (cycle,) = shown(other, 2).cycles
    assert cycle.x == pytest.approx([0.4, 0.8], abs=NEAR)
    assert cycle.multiplier == 0.0


@pytest.mark.parametrize("order", [1, 2, 3])
def test_where_nothing_stays_there_is_nothing(order: int) -> None:
    """x - 2 leads below the window (0, 1) from everywhere; with a jump to 3 as well."""
    away = one_piece(Line(1.0, 0.0, -2.0).smooth())
    assert (shown(away, order).cycles, shown(away, order).jumps) == ((), ())
    both = lines(Line(1.0, 0.0, -2.0), Line(1.0, 0.0, 3.0), at=0.5)
    assert shown(both, order).cycles == ()


# --- Jumps ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_every_jump_of_the_doubling_map(order: int) -> None:
    """P_j jumps at odd multiples of 2**-j, from 1 to 0: across the diagonal."""
    found = shown(doubling(), order, (-0.001, 1.001))
    newest = sorted(jump.x for jump in found.jumps if len(jump.head) == order)
    expected = [k / 2**order for k in range(1, 2**order, 2)]
    assert newest == pytest.approx(expected, abs=NEAR)
    for jump in found.jumps:
        assert sorted((jump.inner.value, jump.outer.value)) == pytest.approx([0.0, 1.0], abs=1e-12)
        assert jump.crosses


# --- The toy --------------------------------------------------------------------------------------


@SLOW_TOY
def test_slices_of_the_toy() -> None:
    """Fixed points and jumps at eps_N1 = 0.5 and 0.35, where the island I1 is open."""
    settings = Settings(window=(-2.5, -0.24))
    half, island = (slices_at(ToyPieces(Toy()), p, (1,), settings)[0] for p in (0.5, 0.35))
    near = -1.3  # what lies left of it is steep, and more than was asked for before
    assert [x for x in fixed(half) if x > near] == pytest.approx(
        [-1.2506951, -1.2247535, -0.52947197], abs=1e-6
    )
    assert half.jumps == ()
    found = fixed(island)
    for x in (-1.3721674, -1.349971, -0.9823319, -0.5638865):
        assert min(abs(x - each) for each in found) < 1e-6
    assert [jump.x for jump in island.jumps] == pytest.approx([-0.8847733440], abs=1e-9)


@NEEDS_NUMBA
def test_a_window_whose_middle_is_a_border_of_the_toy() -> None:
    """At some of the doubles there the toy takes a path of both strikes at once, and no other one.

    Its jump is that of the pieces on both sides, to the rounding of a steep return; there is one.
    """
    map_, p, away = ToyPieces(Toy()), 0.11217091445662577, 2.0**-12
    (border,) = borders_in(map_, p, (-0.8849, -0.8847))
    keys = set[bytes]()
    for k in range(-8, 9):
        x = border.x + k * math.ulp(border.x)
        keys.add(map_.taken(x, p)[0])
        (found,) = borders_in(map_, p, (x - away, x + away))
        assert found.x == pytest.approx(border.x, rel=16 * 2.0**-52)
        assert found.jump == pytest.approx(border.jump, abs=1e-12)
        assert "at once" in found.cause
    assert len(keys) > 2
