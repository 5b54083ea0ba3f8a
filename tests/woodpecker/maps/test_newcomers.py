"""What is asked of the engine at first: starts that are none, maps of one's own, settled orbits."""

from dataclasses import dataclass

import numpy as np
import pytest
from maps import continued, everything
from sympy import Piecewise, Rational, sqrt, symbols

from woodpecker import (
    FormulaMap,
    FormulaPiece,
    Search,
    Settings,
    ShootingStatus,
    Smooth,
    from_sympy,
    shoot,
    slices_at,
)
from woodpecker.examples import two_lines
from woodpecker.maps import check_derivatives
from woodpecker.maps.pieces import Image
from woodpecker.search.diagrams import cycle_near

x, p = symbols("x p")
lines = pytest.fixture(two_lines)


@pytest.mark.parametrize(("guess", "at", "found"), [(-1.0, 0.5, "1"), (50.0, -0.5, "-2.25")])
def test_a_virtual_cycle_is_refused(lines: FormulaMap, guess: float, at: float, found: str) -> None:
    """x/2 + p has the fixed point 2 p, which is its own for p < 0; the other one 3 (p - 1)/2."""
    settings = Settings(span=(-1, 1))
    with pytest.raises(ValueError, match=f"a virtual one is found, at {found} the map takes"):
        cycle_near(lines, guess, at, settings)


def test_shooting_leaves_a_virtual_cycle_for_one_of_the_map(lines: FormulaMap) -> None:
    """At 1/2 there is none, but a jump across the diagonal; at -1/2 there is that of x/2 + p."""
    assert shoot(lines, -0.005, p=0.5).status is ShootingStatus.AT_JUMP
    assert shoot(lines, 50.0, p=-0.5).points == (-1.0,)


def test_a_cycle_right_at_a_border_is_none_that_is_virtual(lines: FormulaMap) -> None:
    assert cycle_near(lines, -0.1, 0.0, Settings(span=(-1, 1))).x.tolist() == [0.0]


def test_a_start_must_lie_in_span_and_window(lines: FormulaMap) -> None:
    with pytest.raises(ValueError, match=r"span must hold p = -0.5, got \(0.0, 1.0\)"):
        continued(lines, -1.0, -0.5, Settings(span=(0, 1)))
    with pytest.raises(ValueError, match=r"window must hold the orbit, x = -1, got \(0.0, 3.0\)"):
        continued(lines, -1.0, -0.5, Settings(span=(-1, 1), window=(0, 3)))


@pytest.mark.nightly
def test_cycles_that_are_born_at_a_square_root_are_connected() -> None:
    """p - 6/5 sqrt(x) right of 0: cycles of all periods start there, as slices show them."""
    rooted = from_sympy(Piecewise((x / 2 + p, x < 0), (p - Rational(6, 5) * sqrt(x), True)), x, p)
    settings = Settings(span=(-1, 1), window=(-3, 3))
    orders = 1, 2, 3, 4
    diagram = continued(rooted, -0.5, -0.25, settings, orders=orders)
    whole = everything(rooted, settings, orders=orders, search=Search(slices=8)).diagram
    ends = [
        sorted((b.order, *sorted(np.round(b.parameter[[0, -1]], 9))) for b in each.branches)
        for each in (diagram, whole)
    ]
    assert ends[0] == ends[1]
    assert len(ends[0]) == 35


# --- Maps of one's own ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Own:
    """A line of a map of one's own, with numpy's numbers."""

    word: str
    slope: float
    height: float
    side: float
    codes: tuple[int, ...] = (0,)

    @property
    def key(self) -> str:
        return self.word

    def at(self, x: float, p: float) -> Image:
        value = np.float64(self.slope * x + self.height + p)
        margins = np.array([self.side * x] * len(self.codes))
        gradients = np.array([[self.side, 0.0]] * len(self.codes))
        return Image(value, self.slope, 1.0, margins, gradients, np.array(self.codes), self)

    def cause(self, code: int) -> str:
        return f"border {code}"


@dataclass(frozen=True)
class OwnMap:
    """Two of them."""

    left: Own = Own("L", 0.5, 0.0, -1.0)
    right: Own = Own("R", 1 / 3, -1.0, 1.0)

    def at(self, x: float, p: float) -> Image:
        return (self.left if x < 0.0 else self.right).at(x, p)


@pytest.mark.parametrize("number", [np.float64, np.float32])
def test_a_root_of_a_negative_number_of_numpy_is_no_value(number: type[np.floating]) -> None:
    x, p = symbols("x p", real=True)
    root = Rational(3, 10)
    formula = Piecewise((1 - p * (-x) ** root, x < 0), (-1 + p * x**root, True))
    roots, settings = from_sympy(formula, x, p), Settings(span=(0.5, 2), window=(-1.5, 1.5))
    own = FormulaPiece("L", Smooth(lambda x, p: 1.0 - p * (-x) ** 0.3))
    for piece in (roots.pieces[0], own):
        assert piece.at(number(-0.25), number(1.25)).value == pytest.approx(1 - 1.25 * 0.25**0.3)
        assert piece.at(0.25, number(1.25)).reason  # not the real part of a complex one
    (found,), (expected,) = (slices_at(roots, p, (2,), settings) for p in (number(1.25), 1.25))
    assert [cycle.x.tolist() for cycle in found.cycles] == [
        cycle.x.tolist() for cycle in expected.cycles
    ]


def test_what_a_piece_lacks_is_said() -> None:
    class NoKey:
        word = "N"

        def at(self, x: float, p: float) -> Image:
            return Image(x, 1.0, 0.0, np.zeros(0), np.zeros((0, 2)), np.zeros(0, int), self)  # type: ignore[arg-type]

    with pytest.raises(TypeError, match="a piece must have 'key'"):
        check_derivatives(NoKey(), [(0.5, 0.5)])  # type: ignore[arg-type]
    twice = OwnMap(left=Own("L", 0.5, 0.0, -1.0, (0, 0)))
    with pytest.raises(ValueError, match=r"ascending codes, got 2, \(2, 2\), \[0, 0\]"):
        check_derivatives(twice, [(-0.5, 0.5)])
