"""Every call ends: what bounds it is counted, it says what it left, and keeps the rest."""

from __future__ import annotations

import numpy as np
import pytest
from maps import continued, everything
from sympy import Piecewise, cos, symbols

from pwmap import PointStatus
from woodpecker import (
    FormulaMap,
    FormulaPiece,
    Search,
    Settings,
    Smooth,
    Toy,
    ToyPieces,
    from_sympy,
    shoot,
    slices_at,
)
from woodpecker.diagrams import bifurcation_search
from woodpecker.engine.curves import Stop
from woodpecker.maps.counting import Allowance, as_counting
from woodpecker.maps.pieces import Image
from woodpecker.search import Stage
from woodpecker.slices.partition import partition

X, P = symbols("x p")


def shifted(x0: int, p0: int) -> FormulaMap:
    """Two lines that jump at x = x0, over a parameter that is counted from p0."""
    x, p = X - x0, P - p0
    formula = Piecewise((x0 + x / 2 + p, x0 > X), (x0 + x / 3 + p - 1, True))
    return from_sympy(formula, X, P, words=["L", "R"])


def many_pieces(steps: int) -> FormulaMap:
    """A staircase of so many steps on (0, 1)."""

    def step(k: int) -> FormulaPiece:
        low, high = k / steps, (k + 1) / steps
        value = Smooth(lambda _, p: 0.5 * low + p, lambda *_: 0.0, lambda *_: 1.0)
        margins = {
            f"x = {low}": Smooth(lambda x, _: x - low, lambda *_: 1.0, lambda *_: 0.0),
            f"x = {high}": Smooth(lambda x, _: high - x, lambda *_: -1.0, lambda *_: 0.0),
        }
        return FormulaPiece(str(k), value, margins)

    return FormulaMap([step(k) for k in range(steps)])


# --- A scale is no magnitude ----------------------------------------------------------------------


@pytest.mark.parametrize(("x0", "p0"), [(0, 0), (1000, 0), (0, 1000), (1000, 1000), (-64, 8)])
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_windows_and_spans_may_be_narrow_and_far_from_zero(x0: int, p0: int, size: float) -> None:
    """Branches end where they do about zero: at p = 0 and p = 1, but for rounding of p0 + p.

    A span or window of 1/1000 about 1000 has 2^-52 1000 / 0.001 = 2e-10 of its length between
    doubles.
    """
    low, high = -0.5 * size, 0.25 * size
    settings = Settings(span=(p0 + low, p0 + high), window=(x0 - 2.0 * size, x0 + 2.0 * size))
    found = continued(shifted(x0, p0), x0 + 2.0 * low, p0 + low, settings)
    ends = sorted(point.parameter - p0 for point in found.points if point.kind.name == "BC")
    assert ends == pytest.approx([0.0], abs=4e-16 * max(1, abs(p0), abs(x0)))
    assert all(point.status is PointStatus.LOCATED for point in found.points)
    assert [branch.word for branch in found.branches] == ["L", "L / R"]


def test_a_span_may_be_as_narrow_as_rounding_lets_it() -> None:
    """Over 1e-9 the stable motion hardly moves: it is one branch from end to end."""
    low, high = 0.5, 0.5 + 1e-9
    found = bifurcation_search(
        Toy(), "eps_n1", (low, high), (1,), (-0.54, -0.52), search=Search(slices=2), workers=1
    )
    (branch,) = found.diagram.branches
    assert sorted(branch.parameter[[0, -1]].tolist()) == [low, high]
    assert branch.x == pytest.approx(shoot(Toy(), -0.53).phi_s, abs=1e-9)
    assert found.evaluations < 2_000


def test_the_unit_of_a_narrow_interval_is_a_part_of_its_magnitude() -> None:
    narrow = Settings(span=(0.5, 0.5 + 1e-9), window=(-1000.001, -1000.0))
    assert narrow.p_scale == (0.5 + 1e-9) / 256
    assert narrow.x_scale == 1000.001 / 256
    assert narrow.nearest * narrow.x_scale > 16 * np.spacing(1000.0)
    assert Settings(span=(0.4, 0.6)).p_scale == 0.6 - 0.4
    with pytest.raises(ValueError, match=r"nearest must be at least converged = 3.55e-15, got 1e-"):
        Settings(nearest=1e-20)


# --- Slices ---------------------------------------------------------------------------------------


@pytest.mark.nightly
def test_pieces_are_bounded_and_what_is_left_is_reported() -> None:
    steps, settings = 40, Settings(window=(0.0, 1.0), max_pieces=10)
    found = partition(many_pieces(steps), 0.1, settings.window, settings)
    assert len(found.cylinders) == 10
    covered = sum(each[-1].x - each[0].x for each in found.cylinders)
    assert covered == pytest.approx(0.25)  # 10 steps of 40
    assert found.unresolved == pytest.approx(0.75)
    every = partition(many_pieces(steps), 0.1, settings.window, Settings(window=(0.0, 1.0)))
    assert len(every.cylinders) == steps
    assert every.unresolved == 0.0


def test_a_slice_is_bounded_where_the_map_has_no_value() -> None:
    """Without friction the toy does not jam: each start runs to the event limit."""
    toy, settings = Toy(mu_1=0, mu_2=0, mu_3=0), Settings(window=(-2.5, -0.24))
    map_ = as_counting(ToyPieces(toy))
    found = partition(map_, 0.5, settings.window, settings, (), Allowance(map_, 1_000))
    assert not found.cylinders
    assert found.unresolved == pytest.approx(2.26)
    assert map_.evaluations < 2_000  # one start counts for some forty, and a gap takes some ten


@pytest.mark.slow
def test_a_window_may_hold_more_than_the_map() -> None:
    """Above phi_S = -0.2391 the toy slides down for ever, and above 0.116 the beak is in the pole.

    What the rest shows is all the same shown, of P_2 too, and takes not many more evaluations.
    """
    map_ = as_counting(ToyPieces(Toy()))
    inside, wide = (
        slices_at(map_, 0.9, (1, 2), Settings(span=(0.012, 1.0), window=(-1.05, high)))
        for high in (-0.24, 0.18)
    )
    spent = map_.evaluations
    for one, other in zip(inside, wide, strict=True):
        seen = [orbit.x for orbit in other.cycles if orbit.x.max() < -0.24]
        assert len(seen) == len(one.cycles)
        for x, orbit in zip(seen, one.cycles, strict=True):
            np.testing.assert_allclose(x, orbit.x, rtol=0.0, atol=1e-12)
        assert len(other.jumps) == len(one.jumps)
    assert spent < 20_000  # 2138 and 9652; 125 000 were allowed, and not enough


@pytest.mark.nightly
def test_the_largest_gaps_are_crossed_first() -> None:
    """A window is looked at everywhere, also if its left half takes all that is allowed."""
    formula = Piecewise((cos(1 / (X + 1e-9)) / 2, X < 0.1), (P + X / 2, X < 0.9), (X / 4, True))
    map_ = as_counting(from_sympy(formula, X, P, words=["wild", "A", "B"]))
    settings = Settings(window=(-0.1, 1.0))
    found = partition(map_, 0.1, settings.window, settings, (), Allowance(map_, 60))
    assert {each[0].image.piece.word for each in found.cylinders} >= {"A", "B"}


def test_pieces_of_an_iterate_are_bounded() -> None:
    """Of the tent map of slope 2 with 2^8 pieces of P_8, only 40 may be looked at."""
    tent = from_sympy(Piecewise((2 * X, X < P), (2 - 2 * X, True)), X, P, words=["L", "R"])
    few = Settings(window=(0.0, 1.0), max_pieces=4)
    (cut,) = slices_at(tent, 0.5, (8,), few)
    assert cut.unresolved == 1.0
    assert 0 < len(cut.cycles) <= 40
    (whole,) = slices_at(tent, 0.5, (8,), Settings(window=(0.0, 1.0)))
    assert (len(whole.cycles), whole.unresolved) == (30, 0.0)  # (2^8 - 2^4)/8 cycles of period 8


# --- Branches and searches ------------------------------------------------------------------------


class Asked:
    """A map that knows how often it was asked, and does not tell by the name a search looks for."""

    def __init__(self, map_: FormulaMap) -> None:
        self.map, self.times = map_, 0

    def at(self, x: float, p: float) -> Image:
        """The image of a point."""
        self.times += 1
        return self.map.at(x, p)


def test_a_search_counts_every_evaluation() -> None:
    """Also those of branches that go on where others end, which hold the map of another task."""
    map_, few = Asked(shifted(0, 0)), Search(slices=4)
    found = bifurcation_search(map_, "p", (-1, 2), (1, 2), (-3, 3), search=few, workers=1)
    assert found.evaluations == map_.times > 0


@pytest.mark.slow
def test_a_branch_ends_after_as_many_evaluations_as_allowed() -> None:
    """It keeps what it has: the same samples as the one that goes on."""
    map_, start = shifted(0, 0), (-1.0, -0.5)
    settings = Settings(span=(-1.0, 2.0), max_step=1e-3, step=1e-3)
    whole = continued(map_, *start, settings).branches[0]
    found = continued(map_, *start, Settings(span=(-1.0, 2.0), max_step=1e-3, step=1e-3,
                                             max_evaluations=200))  # fmt: skip
    cut = found.branches[0]
    notes = {(point.note, point.status) for point in found.points}
    assert notes == {(Stop.SPENT.value, PointStatus.OPEN)}
    assert len(cut.parameter) < len(whole.parameter)
    assert set(cut.parameter.tolist()[1:-1]) <= set(whole.parameter.tolist())


@pytest.mark.nightly
def test_a_branch_of_a_search_leaves_evaluations_for_others() -> None:
    """Alone it goes to the end of the span; among others it may take a sixth of all evaluations.

    So may each of the four arms of the two branches, from the span's ends and from the borders.
    """
    map_, start = shifted(0, 0), (-1.0, -0.5)
    settings = Settings(
        span=(-1.0, 2.0), window=(-3.0, 3.0), max_step=3e-4, step=3e-4, max_evaluations=12_000
    )
    alone = continued(map_, *start, settings)
    assert all(point.status is PointStatus.LOCATED for point in alone.points)
    found = everything(map_, settings, search=Search(slices=1))
    assert 4 * 2_000 <= found.evaluations < 4 * 2_000 + 200
    given_up = [point for point in found.diagram.points if point.status is PointStatus.OPEN]
    assert [point.note for point in given_up] == 4 * [Stop.SPENT.value]
    assert len(found.diagram.branches) == 5
    assert not found.left


@pytest.mark.nightly
def test_a_search_says_what_it_left() -> None:
    map_ = many_pieces(30)
    settings = Settings(span=(0.0, 0.4), window=(0.0, 1.0), max_evaluations=1_500)
    told = list[Stage]()
    found = everything(map_, settings, search=Search(slices=31), progress=told.append)
    assert 1_500 <= found.evaluations <= 1_500 + settings.of_branch(1) + settings.of_slice((1,))
    assert found.left.startswith("given up after 1500 evaluations, as many as allowed")
    assert found.left.endswith(" not taken")
    assert found.diagram.about["left"] == found.left
    assert found.left in repr(found)
    assert len(found.slices) < 33
    assert told[0].branches == 0  # from the beginning
    whole = everything(map_, Settings(span=(0.0, 0.4), window=(0.0, 1.0)),
                          search=Search(slices=31))  # fmt: skip
    assert not whole.left
    assert "left" not in whole.diagram.about


@pytest.mark.slow
def test_without_friction_a_search_ends() -> None:
    """It took more than twenty minutes; as many evaluations are allowed as take a second."""
    settings = Settings(max_evaluations=20_000)
    found = bifurcation_search(
        Toy(mu_1=0, mu_2=0, mu_3=0), "eps_n1", (0.0, 1.0), (1,), settings=settings, workers=1
    )
    assert not found.diagram.branches
    assert found.evaluations < 20_000 + 1_300  # one slice more at most
    assert found.left.endswith("not taken")
    assert max(seen.unresolved for seen in found.slices) == pytest.approx(2.26)
