"""The same verbs take the toy and any map, and give the same types; old ones name the new call."""

import math
import warnings
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from maps import fold, two_lines
from rooms import ROOMS

import woodpecker
from pwmap import Diagram, PiecewiseLinearMap
from woodpecker import (
    OrbitDiagram,
    PeriodicOrbit,
    ReturnMap,
    Search,
    Settings,
    ShootingStatus,
    Status,
    Toy,
    ToyPieces,
    bifurcation_diagram,
    continuation,
    curve_in_two,
    first_return,
    orbit_diagram,
    return_map,
    shoot,
)
from woodpecker.plane import family_from_pwmap

EXACT = PiecewiseLinearMap.from_sympy("Piecewise((p + x/2, x <= 0), (p - 1 + x/3, True))")
P1L = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - a*x, True))", given=["a > 1"])
TOY = Toy()


# --- One point ------------------------------------------------------------------------------------


def test_a_map_is_shot_for_like_the_toy() -> None:
    """x/2 + p has the fixed point 2 p; of x/2 + p and x/3 + p - 1 no two are a cycle."""
    found = shoot(EXACT, -0.9, p=-0.5)
    assert isinstance(found, PeriodicOrbit)
    assert found.x == pytest.approx(-1.0, abs=2e-16)  # a spacing of doubles
    assert (found.p, found.multiplier, found.word) == (-0.5, 0.5, "L")
    assert math.isnan(found.period)
    twice = shoot(EXACT, -0.9, 2, p=-0.5)
    assert (twice.order, twice.minimal_period) == (2, 1)
    assert twice.points == pytest.approx((-1.0, -1.0), abs=2e-16)
    with pytest.raises(TypeError, match=r"source of the orbit must be woodpecker\.Toy"):
        found.toy  # noqa: B018


def test_what_shooting_does_not_find_has_a_status() -> None:
    """x + p - x^2 has no fixed point for p < 0."""
    lost = shoot(fold(), 0.5, p=-0.1)
    assert (lost.success, lost.status) == (False, ShootingStatus.NOT_CONVERGED)


def test_the_toy_and_its_map_have_the_same_orbit() -> None:
    toy, map_ = shoot(TOY, -0.53), shoot(ToyPieces(TOY), -0.53, p=0.5)
    assert (toy.points, toy.multiplier, toy.word) == (map_.points, map_.multiplier, map_.word)


# --- Many points ----------------------------------------------------------------------------------


def test_returns_of_a_map() -> None:
    found = return_map(EXACT, [-1.0, 1.0], 2, p=0.25)
    assert isinstance(found, ReturnMap)
    # -1 -> -1/4 -> 1/8, and 1 -> -5/12 -> 1/24
    assert found.phi_s == pytest.approx([1 / 8, 1 / 24], abs=1e-16)
    assert found.slope == pytest.approx([1 / 4, 1 / 6], rel=1e-15)
    assert found.words == ("L | L", "R | L")
    assert found.status == (Status.RETURNED, Status.RETURNED)


def test_returns_of_the_map_of_the_toy_are_its_own() -> None:
    starts = [-1.0, -0.53]
    own, by_map = return_map(TOY, starts), return_map(ToyPieces(TOY), starts, p=0.5)
    assert by_map.phi_s == pytest.approx(own.phi_s, abs=1e-13)  # searched and followed
    assert by_map.words == own.words
    lost = return_map(ToyPieces(TOY), [-0.05], p=0.5)
    assert lost.status == (Status.NO_IMAGE,)
    assert math.isnan(lost.phi_s[0])
    assert lost.words[0] == first_return(TOY, -0.05).status.value


def test_orbits_settle_on_the_same_for_the_toy_and_its_map() -> None:
    given = ([0.5], [-0.53], (-2.5, -0.24))
    of = (TOY, ToyPieces(TOY))
    toy, map_ = (orbit_diagram(each, *given, transient=100, keep=4) for each in of)
    assert isinstance(toy, OrbitDiagram)
    assert toy.orbits[0].x.tolist() == map_.orbits[0].x.tolist()
    exact = orbit_diagram(EXACT, [-0.5], [0.3], (-3.0, 3.0))
    assert exact.orbits[0].x[-1] == pytest.approx(-1.0, abs=1e-15)


def test_numbers_of_any_kind_are_numbers() -> None:
    """The kernel is compiled for floats alone, and sees no other."""
    expected = first_return(TOY, -0.5).phi_s
    for start in (np.float64(-0.5), np.array(-0.5), Fraction(-1, 2), Decimal("-0.5")):
        assert first_return(TOY, start).phi_s == expected  # type: ignore[arg-type]
        # found once more along its path
        image = ToyPieces(TOY).at(start, Fraction(1, 2))  # type: ignore[arg-type]
        assert image.value == pytest.approx(expected, rel=1e-14)


# --- Diagrams -------------------------------------------------------------------------------------


def test_an_exact_map_is_followed_as_it_is() -> None:
    """The fixed point meets the jump at p = 0; the jump crossing leads to p = 1."""
    found = continuation(EXACT, shoot(EXACT, -0.9, p=-0.5), span=(-1, 2))
    assert isinstance(found, Diagram)
    assert (found.parameter_name, found.x_name) == ("p", "x")
    assert [branch.word for branch in found.branches] == ["L", "L / R", "R"]
    assert [point.parameter for point in found.points] == pytest.approx([-1, 0, 1, 2], abs=1e-15)
    whole = bifurcation_diagram(EXACT, "p", (-1, 2), window=(-3, 3), search=Search(slices=4))
    assert [branch.word for branch in whole.branches] == ["L", "L / R", "R"]


def test_span_and_window_are_those_of_the_settings() -> None:
    map_, settings = two_lines(), Settings(span=(-1, 2), window=(-3, 3))
    few = Search(slices=4)
    one = bifurcation_diagram(map_, settings=settings, search=few)
    other = bifurcation_diagram(map_, "p", (-1, 2), (1,), (-3, 3), search=few)
    assert one.points == other.points


def test_an_exact_map_of_two_parameters_goes_where_its_family_does() -> None:
    """The collision of P1^L at r = 0, for every a."""
    family = family_from_pwmap(P1L, ("r", "a"))
    over = family.over(0, (0.0, 1.25))
    settings = Settings(span=(-1, 1), window=(-4, 4))
    point = continuation(over, shoot(over, 0.2, p=0.45), settings=settings).points[0]
    spans = ((-1.0, 1.0), (1.1, 2.0))
    found = [
        curve_in_two(each, point, ("r", "a"), spans, value=1.25, settings=settings)
        for each in (P1L, family)
    ]
    assert found[0].values.tolist() == found[1].values.tolist()
    assert found[0].values[:, 0] == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(ValueError, match="parameters must be those of the family"):
        curve_in_two(family, point, ("a", "r"), spans, value=1.25, settings=settings)


# --- What has another name ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("connected", r"call woodpecker\.continuation\(map_, shoot\(map_, x, p=p\)"),
        ("cycle_near", r"call woodpecker\.shoot\(map_, x, p=p\)"),
        ("whole_diagram", r"call woodpecker\.bifurcation_diagram\(map_, settings=settings\)"),
        ("curve_through", r"call woodpecker\.curve_in_two\(family, point"),
        ("find_all", r"it is woodpecker\.diagrams\.bifurcation_search now"),
        ("Undecided", r"it is woodpecker\.proofs\.NotProved now"),
        ("Trouble", r"it is woodpecker\.robustness\.SmallestChange now"),
        ("Border", r"it is woodpecker\.slices\.Border now"),
    ],
)
def test_an_old_name_says_the_new_one(name: str, said: str) -> None:
    with pytest.warns(DeprecationWarning, match=f"woodpecker.{name} is deprecated: {said}"):
        assert callable(getattr(woodpecker, name))


def test_every_old_name_is_still_there_and_no_new_one() -> None:
    """What left the top is in a room, itself; rooms and top name nothing twice."""
    old = [*woodpecker._PLACES, *woodpecker._GONE]
    assert not set(old) & set(woodpecker.__all__)
    for name in old:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            assert getattr(woodpecker, name) is not None
    for room in ROOMS[woodpecker]:
        for name in set(room.__all__) & set(woodpecker.__all__):
            assert getattr(room, name) is getattr(woodpecker, name)
