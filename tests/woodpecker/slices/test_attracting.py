"""Orbit diagrams of maps whose attractors are known, and of the toy beside its branches."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from legends import explained
from maps import logistic, paper
from sympy import Piecewise, sqrt, symbols, sympify

from pwmap import Branch, BranchKind, Diagram, PointKind, SpecialPoint
from pwmap.plot import plot_diagram
from pwmap.plot.palette import of_period
from woodpecker import (
    Toy,
    ToyPieces,
    from_sympy,
    orbit_diagram,
)
from woodpecker.base.arrays import Floats
from woodpecker.base.settings import Settings
from woodpecker.maps import Sweep
from woodpecker.plot.orbits import plot_orbits
from woodpecker.slices import unexplained
from woodpecker.slices.attracting import periods_of

WIDE = (-100.0, 100.0)


@pytest.mark.parametrize(("r", "period"), [(1.0, 1), (2.2, 3), (2.5, 5), (8.0, 4), (11.0, 2)])
def test_superstable_cycles_of_the_papers_map(r: float, period: int) -> None:
    """Beyond r = 2 the exact diagram has one superstable cycle in each of these cells."""
    found = orbit_diagram(paper(), r, np.linspace(-3.0, 3.0, 7), WIDE)
    assert found.lost == 0
    assert {orbit.period for orbit in found.orbits} == {period}
    assert {orbit.exponent for orbit in found.orbits} == {-math.inf}
    assert np.abs(found.orbits[0].x - (r - 2.0)).min() == 0.0


@pytest.mark.slow
def test_exponents_of_the_logistic_map() -> None:
    """log 2 at p = 4; log |2 - p| at the fixed point."""
    chaotic = orbit_diagram(logistic(), 4.0, 0.1234, (0.0, 1.0), keep=4000)
    (orbit,) = chaotic.orbits
    assert orbit.period == 0
    assert orbit.exponent == pytest.approx(math.log(2.0), abs=0.02)  # like keep**-0.5
    (fixed,) = orbit_diagram(logistic(), 2.5, 0.1234, (0.0, 1.0)).orbits
    assert (fixed.period, fixed.exponent) == (1, pytest.approx(math.log(0.5), rel=1e-6))
    assert fixed.x[-1] == pytest.approx(0.6, abs=1e-12)


def test_orbits_that_leave_are_counted() -> None:
    found = orbit_diagram(logistic(), [4.5, 2.5], [0.1, 0.5], (0.0, 1.0))
    assert found.lost == 2
    assert {orbit.p for orbit in found.orbits} == {2.5}
    p, x = found.points()
    assert p.shape == x.shape == (2 * 128,)


def period_of(x: npt.ArrayLike, settings: Settings) -> int:
    (found,) = periods_of(np.array([x]) / settings.x_scale).tolist()
    return int(found)


def test_periods() -> None:
    rows = np.array([[1.0, 2.0, 3.0] * 10, np.linspace(0.0, 1.0, 30), [1.0] * 30])
    assert periods_of(rows / Settings().x_scale).tolist() == [3, 0, 1]


def test_what_counts_as_a_period_is_set() -> None:
    lengths = (64, 65)  # the longest period that is looked for, and one more
    assert [period_of(np.arange(3.0 * n) % n, Settings()) for n in lengths] == [64, 0]
    three = np.array([1.0, 2.0, 3.0] * 10)
    three[-1] += 1.5e-6  # a part of the window: 1e-6 of it is 1e-6 or 2e-6
    assert [period_of(three, Settings(window=(0.0, end))) for end in (1.0, 2.0)] == [0, 3]


# --- Many points at once --------------------------------------------------------------------------

X, P = symbols("x p")
TENT = Piecewise((P * X, sympify("1/2") >= X), (P * (1 - X), True))


class Counting:
    """The tent map, which counts how often it is asked, and with which shapes."""

    def __init__(self) -> None:
        self.asked: list[tuple[int, ...]] = []

    def sweep(self, x: Floats, p: Floats) -> Sweep:
        self.asked.append((*x.shape, *p.shape))
        return Sweep(p * np.minimum(x, 1.0 - x), np.where(x < 0.5, p, -p))


def test_all_parameters_are_asked_for_in_one_call() -> None:
    """Each iterate is one call; by numpy's arithmetic the orbits are those of the formula."""
    values, starts = np.linspace(1.1, 1.9, 9), [0.2, 0.3]
    tent = Counting()
    found = orbit_diagram(tent, values, starts, (0.0, 1.0), transient=20, keep=10)
    assert tent.asked == [(18, 18)] * 30
    assert [(o.p, o.start) for o in found.orbits] == [(p, s) for p in values for s in starts]
    assert [o.exponent for o in found.orbits] == pytest.approx(
        [math.log(o.p) for o in found.orbits]
    )


def test_maps_of_sympy_take_many_points_at_once() -> None:
    """As one by one: the two sides of the break, and points outside of a root's domain."""
    root = from_sympy(Piecewise((P + sqrt(X), X > 0), (P - X / 2, X > -1)), X, P, words=["R", "L"])
    x = np.array([0.25, 0.0, -0.5, -1.0, -2.0, 4.0])
    p = np.linspace(0.0, 1.0, 6)
    found = root.sweep(x, p)
    once = [root.at(*pair) for pair in zip(x.tolist(), p.tolist(), strict=True)]
    assert found.value == pytest.approx([each.value for each in once], nan_ok=True)
    assert found.slope == pytest.approx([each.slope for each in once], nan_ok=True)
    assert np.isnan(found.value).tolist() == [False, False, False, True, True, False]


def test_a_piece_written_by_hand_goes_one_by_one() -> None:
    found = logistic().sweep([0.1, 0.2], [3.0, 4.0])
    assert found.value == pytest.approx([0.27, 0.64])
    assert found.slope == pytest.approx([2.4, 2.4])


def test_orbits_lie_under_a_diagram_in_the_colours_of_their_periods() -> None:
    tent = from_sympy(TENT, X, P)
    found = orbit_diagram(tent, [0.5, 1.5], [0.3], (0.0, 1.0), keep=32)
    below = plot_diagram(drawn(0.0))
    first = explained(below.ax)
    over = plot_orbits(found, below.ax, styles={"no period": {"alpha": 0.5}})
    assert over.ax is below.ax
    assert [*over.artists] == ["period 1", "no period"]
    dots = {name: each[0] for name, each in over.artists.items()}
    assert dots["period 1"].get_markersize() == 4.0  # type: ignore[attr-defined]  # of 2 columns
    assert dots["period 1"].get_color() == of_period(1)  # type: ignore[attr-defined]
    assert max(each.get_zorder() for each in dots.values()) < 1.0  # of lines: 2
    texts = explained(over.ax)
    assert {"period 1", "no period", "stable"} <= {*texts}
    assert texts[: len(first)] == first
    again = plot_orbits(found, below.ax)  # over a legend of its own, too
    assert explained(again.ax) == texts
    assert len(texts) == len({*texts})


@pytest.mark.parametrize(
    ("source", "names"),
    [
        (Toy(), (r"$\varepsilon_{N1}$", r"$\varphi_S$ [rad]")),
        (from_sympy(TENT, X, P), (f"${P}$", f"${X}$")),
        (Counting(), ("$p$", "$x$")),  # no map of pieces, and without names
    ],
)
def test_axes_are_named_as_in_other_pictures(source: Any, names: tuple[str, str]) -> None:
    window, start = ((-2.5, -0.24), -0.53) if isinstance(source, Toy) else ((0.0, 1.0), 0.3)
    found = orbit_diagram(source, [0.5], [start], window, transient=1, keep=2)
    ax = plot_orbits(found).ax
    assert (ax.get_xlabel(), ax.get_ylabel()) == names


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"keep": 0}, "keep must be a whole number of at least 1, got 0"),
        ({"transient": -1}, "transient must be a whole number of at least 0, got -1"),
        ({"window": (1.0, 0.0)}, "window must ascend"),
        ({"window": (0.0, 1.0, 2.0)}, "window must be two real numbers"),
        ({"starts": [0.1 + 0.0j]}, "starts must be real numbers"),
        ({"parameters": [2.5j]}, "parameters must be real numbers"),
    ],
)
def test_wrong_input_is_named(wrong: dict[str, Any], sentence: str) -> None:
    given: dict[str, Any] = {"parameters": 2.5, "starts": 0.1, "window": WIDE} | wrong
    with pytest.raises(ValueError, match=sentence):
        orbit_diagram(logistic(), **given)


def drawn(shift: float) -> Diagram:
    """The logistic map's fixed points over (2.4, 2.6), shifted, as one straight line."""
    p = np.array([2.4, 2.6])
    x = 1.0 - 1.0 / p + shift
    return Diagram(
        parameter_name="p",
        x_name="x",
        branches=(
            Branch(
                id="F1", kind=BranchKind.FIXED_POINT, order=1, word="S", parameter=p, x=x,
                multiplier=2.0 - p, ends=("EP1", "EP2"),
            ),
        ),
        points=tuple(
            SpecialPoint(
                id=f"EP{k + 1}", kind=PointKind.EP, parameter=p[k], x=x[k], branches=("F1",)
            )
            for k in range(2)
        ),
    )  # fmt: skip


def test_what_no_branch_explains() -> None:
    """The chord of 1 - 1/p over (2.4, 2.6) is off by 6.4e-4 at 2.5; a cycle beside it is another.

    The second fixed point, 0, repels: a branch that lies there explains nothing, however near.
    """
    settled = orbit_diagram(logistic(), 2.5, 0.1234, (0.0, 1.0))
    assert unexplained(settled, drawn(0.0), logistic()) == []
    assert unexplained(settled, drawn(0.0), logistic(), distance=5e-4) == list(settled.orbits)
    assert unexplained(settled, drawn(-0.6), logistic(), distance=1.0) == list(settled.orbits)


def test_a_start_inside_of_the_pole_has_no_return() -> None:
    """The beak touches the pole at phi_S = 0.12; ``at`` says so too."""
    found, toy = ToyPieces(Toy()).sweep([-0.53, 0.119, 0.121, 2.0], 0.5), ToyPieces(Toy())
    for each, value in zip((-0.53, 0.119, 0.121, 2.0), found.value.tolist(), strict=True):
        assert value == pytest.approx(toy.at(each, 0.5).value, nan_ok=True)
    assert np.isnan(found.value[2:]).all()
    assert np.isnan(found.slope[2:]).all()
    with pytest.raises(ValueError, match="eps_n1 must lie in"):
        toy.sweep([-0.53], -0.1)
    assert orbit_diagram(toy, 0.5, 2.0, (-3.0, 3.0), transient=0, keep=1).lost == 1
