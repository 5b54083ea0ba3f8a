"""Regions of two parameters: against exact cells, and against counting."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import sympy
from needs import NIGHTLY_TOY, SLOW_TOY
from shapely import LineString, MultiLineString

import woodpecker.regions
from pwmap import PiecewiseLinearMap, parameter_plane
from woodpecker import Settings, Toy, ToyPieces, shoot
from woodpecker.examples import SETTINGS, border_curve, paper_family
from woodpecker.plane import family_from_sympy
from woodpecker.plot.regions import described
from woodpecker.regions import Regions, Survey, parameter_regions
from woodpecker.regions.census import Count, attractors_at
from woodpecker.regions.cutting import SQUARE, faces_of, lines_of, way_between
from woodpecker.regions.regions import Division

X, A, R = sympy.symbols("x a r")
PAPER = sympy.Piecewise((-2 + R, X < 0), (-A * X + R, True))
SPAN = ((-1.0, 4.0), (0.5, 3.0))


@cache
def of_the_paper() -> Regions:
    """P1^L [Leine2001, Eq. 14] over r and a, from nothing."""
    family = family_from_sympy(PAPER, X, (R, A))
    return parameter_regions(family, ("r", "a"), SPAN, window=(-20.0, 20.0), orders=(1, 2))


@pytest.mark.slow
def test_shares_of_the_paper_are_areas() -> None:
    """By integrals of the borders: r = 0, r = 2, a = 1 and r = 2 a/(a - 1)."""
    found = {region.census: region.share for region in of_the_paper().regions}
    whole = 5.0 * 2.5
    # 2 a/(a - 1) < 4 for a > 2: the area right of it is the integral of 4 - 2 a/(a - 1)
    two = (4.0 - 2.0) - 2.0 * np.log(2.0)
    expected = {
        ((1, 1, 0), (2, 0, 0)): (1.0 * 2.5 + 2.0 * 0.5) / whole,
        ((1, 2, 0), (2, 0, 0)): 2.0 * 0.5 / whole,
        ((1, 1, 1), (2, 0, 0)): 2.0 * 2.0 / whole,
        ((1, 0, 1), (2, 1, 0)): two / whole,
        ((1, 0, 1), (2, 0, 0)): (2.0 * 2.0 - two) / whole,
    }
    shares: dict[object, float] = {}
    for region in of_the_paper().regions:
        shares[region.census] = shares.get(region.census, 0.0) + region.share
    assert found.keys() == expected.keys()
    for census, share in expected.items():
        # straight lines between samples of the one border that bends: 2 a/(a - 1)
        assert shares[census] == pytest.approx(share, abs=2e-5)


def test_a_region_is_described_by_its_cycles_or_by_what_was_sought() -> None:
    assert described((Count(1, 0, 1), Count(2, 1, 0))) == "period 1: 1 unstable; period 2: 1 stable"
    assert described(()) == "no cycle of these orders"


def counted(map_: PiecewiseLinearMap) -> tuple[tuple[int, int, int], ...]:
    """The same from what pwmap proves in a cell."""
    found = []
    for order in (1, 2):
        own = [p for p in map_.iterate(order).fixed_points() if p.admissible and p.period == order]
        stable = sum(point.stable for point in own)
        found.append((order, stable // order, (len(own) - stable) // order))
    return tuple(found)


@pytest.mark.slow
def test_the_exact_plane_of_pwmap_agrees() -> None:
    x, a, r = sympy.symbols("x a r")
    formula = sympy.Piecewise((r - 2, x <= 0), (r - a * x, True))
    whole = PiecewiseLinearMap.from_sympy(formula, x, given=[a > 0])
    plane = parameter_plane(whole, a, r, (sympy.Rational(1, 2), 3), (-1, 4), orders=(1, 2))
    found, compared = of_the_paper(), 0
    for strip in plane.strips:
        middle = (strip.lower + strip.upper) / 2
        for cell in strip.cells:
            low, high = (edge.subs(a, middle) for edge in (cell.lower, cell.upper))
            if not cell.is_edge:
                place = float((low + high) / 2), float(middle)
                assert found.at(*place).census == counted(cell.map)
                compared += 1
    assert compared == 3 + 3 + 4  # below a = 1, up to where 2 a/(a - 1) leaves the span, beyond


@pytest.mark.slow
def test_a_place_on_a_border_is_in_no_region() -> None:
    with pytest.raises(ValueError, match="within a region"):
        of_the_paper().at(10.0, 1.0)


def test_wrong_input_is_refused() -> None:
    family = family_from_sympy(PAPER, X, (R, A))
    with pytest.raises(ValueError, match="finite window"):
        parameter_regions(family, ("r", "a"), SPAN)
    with pytest.raises(ValueError, match="those of the family"):
        parameter_regions(family, ("a", "r"), SPAN)
    with pytest.raises(TypeError, match="progress must be a function, got 3"):
        parameter_regions(family, ("r", "a"), SPAN, window=(-4, 4), progress=3)  # type: ignore[arg-type]
    for count in (0, 2.5, "a", True):
        with pytest.raises(ValueError, match="checks must be a whole number of at least 1, got"):
            Survey(checks=count)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="seed must be a whole number of at least 0, got -1"):
        Survey(seed=-1)
    with pytest.raises(ValueError, match="finest must be one real number, got 'a'"):
        Survey(finest="a")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="beside must lie in"):
        Survey(beside=1.5)


def test_a_curve_is_followed_once_and_kept_whole() -> None:
    curve = border_curve()
    half = len(curve) // 2
    arrays = {name: getattr(curve, name)[:half] for name in ("values", "x", "multipliers", "gaps")}
    part = replace(curve, **arrays, codes=curve.codes[:half], notes=curve.notes[:half])
    found = Division(
        paper_family(), ((-1.0, 1.0), (1.1, 2.0)), SETTINGS, (1,), Survey(), SETTINGS.window
    )
    ((point, a),) = found._points(0, (0.4, 0.5), (0.6, 0.5))  # of r, which is 0 on the curve
    followed = found._followed(point, a, 0)
    assert followed is not None
    assert np.abs(followed.values[:, 0]).max() < 1e-12
    found.add(part)
    found.add(curve)
    assert found.curves == [curve]  # the part of it is gone
    assert found._followed(point, a, 0) is None


def test_a_thin_face_is_not_counted_and_belongs_to_a_neighbour() -> None:
    """Between two curves that are 1/2000 of the span apart, a quarter of what counts as thin."""
    curve, survey = border_curve(), Survey(beside=1e-4)
    found = Division(
        paper_family(), ((-1.0, 1.0), (1.1, 2.0)), SETTINGS, (1,), survey, SETTINGS.window
    )
    for shift in (0.0, 1e-3):
        found.add(replace(curve, values=curve.values + np.array([shift, 0.0])))
    assert len(found.faces) == 3
    assert len(found.faces_with_places()) == 2
    shares = [region.share for region in found.result().regions]
    assert shares == pytest.approx([0.5, 0.5], abs=1e-3)
    assert sum(shares) == pytest.approx(1.0, abs=1e-9)


def test_a_curve_that_ends_right_beside_another_cuts_a_face() -> None:
    """As far as curves are known: their ends are samples, one of which lies 0.001 too far left."""
    border, spans = border_curve(), ((-1.0, 1.0), (1.1, 2.0))
    row = np.array([[-1.0, 1.5], [-1e-3, 1.5]])
    across = replace(border, values=row, codes=border.codes[:2], notes=border.notes[:2])
    faces = [faces_of(lines_of([border, across], spans, near)) for near in (1e-3, 1e-4)]
    assert [len(each) for each in faces] == [3, 2]  # 0.001 is 1/2000 of the span
    # left of the border above and below the row, and right of it
    areas = sorted(face.area for face in faces[0])
    assert areas == pytest.approx([0.5 * 4 / 9, 0.5 * 5 / 9, 0.5], rel=1e-9)


def test_a_curve_is_whole_where_its_jump_closes() -> None:
    """At one sample nothing happens, between two of them there is no border (before: gaps)."""
    border, spans = border_curve(), ((-1.0, 1.0), (1.1, 2.0))
    notes = ["fold"] * len(border)
    for k in (3, 7, 8):
        notes[k] = "word change"
    lines = lines_of([replace(border, notes=tuple(notes))], spans, 1e-9)
    quiet = float(border.values[8, 1] - border.values[7, 1]) / 0.9  # along the border, r = 0
    assert lines.length == pytest.approx(lines_of([border], spans, 1e-9).length - quiet, abs=1e-9)
    assert len(lines.geoms) == 2


@pytest.mark.slow
def test_constants_on_both_sides_have_a_region_in_each_quadrant() -> None:
    """f = p for x < 0, f = q beyond: each lies on its own side or not, and if neither does, they
    make a cycle of two (before: three regions were one, with eleven places that disagree)."""
    family = family_from_sympy(sympy.Piecewise((R, X < 0), (A, True)), X, (R, A))
    found = parameter_regions(
        family, ("r", "a"), ((-1, 1), (-1, 1)), window=(-4, 4), orders=(1, 2),
        survey=Survey(checks=20),
    )  # fmt: skip
    assert found.open == ()
    assert [region.share for region in found.regions] == pytest.approx([0.25] * 4, abs=1e-4)
    for r, a in ((-0.5, 0.5), (-0.5, -0.5), (0.5, 0.5), (0.5, -0.5)):
        one = (r < 0) + (a >= 0)
        assert found.at(r, a).census == ((1, one, 0), (2, one == 0, 0))


def test_no_place_of_a_region_lies_on_the_middle_of_its_square() -> None:
    """There a fixed point passes the break, and is not counted (before: one place disagreed)."""
    formula = sympy.Piecewise((X / 2 + R + A / 10**30, X < 0), (X / 3 + R, True))
    family = family_from_sympy(formula, X, (R, A))
    few = Survey(checks=5, starts=2, transient=20, keep=8)
    found = parameter_regions(family, ("r", "a"), ((-1, 1), (-1, 1)), window=(-4, 4), survey=few)
    assert found.open == ()
    assert [region.census for region in found.regions] == [((1, 1, 0),)]


@SLOW_TOY
@pytest.mark.parametrize(
    ("second", "place", "attractor"),
    [  # after 500 returns some orbits are right before their cycle, or diverge slowly
        ("c_phi", (0.5097304234318676, 0.0053006077264642305), "period 1"),
        ("l_s", (0.15660256329053943, 0.01999601430041889), "chaos"),
    ],
)
def test_orbits_that_settle_late_are_told_by_what_they_come_to(
    second: str, place: tuple[float, float], attractor: str
) -> None:
    map_ = ToyPieces(Toy(**{second: place[1]}), "eps_n1")
    settings = Settings(window=(-0.9, -0.45))
    found = attractors_at(map_, place[0], settings, (-2.5, -0.24), Survey())
    assert [str(each) for each in found] == [attractor]


@NIGHTLY_TOY
def test_regions_of_the_toy_beside_the_flip() -> None:
    """Right of the flip at 0.6485 the cycle is unstable; shooting says the same."""
    toy = Toy()
    found = parameter_regions(
        toy, ("eps_n1", "mu_2"), ((0.55, 0.75), (0.297, 0.303)), window=(-0.6, -0.45),
        survey=Survey(checks=20),
    )  # fmt: skip
    assert found.open == ()
    assert found.checks == 20
    assert any(curve.kind == "PD" for curve in found.curves)
    rng = np.random.default_rng(9)
    for eps_n1, mu_2 in zip(
        rng.uniform(0.55, 0.75, 20), rng.uniform(0.297, 0.303, 20), strict=True
    ):
        orbit = shoot(toy.replace(eps_n1=eps_n1, mu_2=mu_2), -0.52)
        assert orbit.success
        if abs(abs(orbit.multiplier) - 1.0) > 0.01:
            ((_, stable, unstable),) = found.at(eps_n1, mu_2).census
            assert (stable, unstable) == ((1, 0) if orbit.stable else (0, 1))


def test_a_way_leads_round_a_line_that_ends_inside() -> None:
    """Over the end of the slit at (1/2, 3/4), not through it; and none through a whole cut."""
    a, b = (0.25, 0.25), (0.75, 0.25)
    slit = MultiLineString([[(0.5, 0.0), (0.5, 0.75)]])
    way = LineString(way_between(SQUARE, slit, a, b, 0.01))
    assert (way.coords[0], way.coords[-1]) == (a, b)
    assert SQUARE.contains(way)
    assert way.distance(slit) > 0.0
    cut = MultiLineString([[(0.5, 0.0), (0.5, 1.0)]])
    assert way_between(SQUARE, cut, a, b, 0.01) == []
    assert way_between(SQUARE, MultiLineString(), a, b, 0.01) == [a, b]


@pytest.mark.slow
def test_a_survey_ends_where_no_place_is_far_from_all_borders() -> None:
    """Every place of the rectangle is closer than 0.6 of it to the border at r = 0."""
    family = family_from_sympy(sympy.Piecewise((R - 2, X <= 0), (R - A * X, True)), X, (R, A))
    settings, span = Settings(window=(-4.0, 4.0)), ((-1.0, 1.0), (1.1, 2.0))
    few = Survey(checks=4, beside=0.6, thin=0.01)
    found = parameter_regions(family, family.names, span, settings=settings, survey=few)
    assert found.checks < 4
    assert sum(region.share for region in found.regions) == pytest.approx(1.0)


@pytest.mark.slow
def test_the_old_name_still_works() -> None:
    family, span = family_from_sympy(PAPER, X, (R, A)), ((-1.0, 1.0), (1.1, 2.0))
    settings, few = Settings(window=(-4.0, 4.0)), Survey(checks=4)
    with pytest.warns(DeprecationWarning, match="call parameter_regions"):
        old = woodpecker.regions.regions_of  # type: ignore[attr-defined]
    found = old(family, span=span, settings=settings, survey=few)
    new = parameter_regions(family, family.names, span, settings=settings, survey=few)
    assert [each.census for each in found.regions] == [each.census for each in new.regions]
