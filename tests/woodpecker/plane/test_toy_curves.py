"""Special points of the toy over two parameters."""

from functools import lru_cache

import numpy as np
import pytest
from needs import NEEDS_NUMBA
from toy_points import POINTS

from pwmap.diagrams.diagram import Diagram, PointKind, PointStatus, SpecialPoint
from studies.common.random_toys import random_toy
from studies.two_parameters import island_ends
from woodpecker import (
    Curve,
    Settings,
    Toy,
    bifurcation_diagram,
    continuation,
    curve_in_two,
    shoot,
)
from woodpecker.plane import PlaneKind
from woodpecker.plane.maps import Plane
from woodpecker.plane.toys import ToyFamily

pytestmark = [pytest.mark.slow, NEEDS_NUMBA]

OVER, SPAN = ("eps_n1", "mu_2"), ((0.0, 1.0), (0.286, 0.6))
CLOSE = 1e-9  # of a point that a one-parameter computation locates anew
PLACES = {name: POINTS["summed"][name][2:] for name in "AC"}


@lru_cache
def diagram() -> Diagram:
    """What is connected with the stable motion, at mu_2 = 0.3."""
    toy = Toy()
    return continuation(toy, shoot(toy, -0.53)).named(PLACES)


@lru_cache
def curve(name: str) -> Curve:
    """The curve of a point of that diagram."""
    return curve_in_two(Toy(), diagram().point(name), OVER, SPAN)


def test_it_ends_where_the_span_does() -> None:
    found = curve("A")
    assert "end of the span of mu_2" in {point.cause for point in found.ends}
    assert found.given[0] == "friction in the expansion: summed"


@pytest.mark.parametrize("name", ["eps_n2", "eps_n3"])
def test_curves_start_where_a_restitution_is_zero(name: str) -> None:
    """They end at points of the diagram of the toy that has the last value."""
    toy, last = Toy(eps_n1=0.5), 5e-4
    over, span = ("eps_n1", name), ((0.012, 1.0), (0.0, last))

    def points(toy: Toy) -> list[SpecialPoint]:
        found = continuation(toy, shoot(toy, -0.53), "eps_n1", span[0]).points
        return [each for each in found if each.kind is not PointKind.EP]

    ends, met = points(toy.replace(**{name: last})), set()
    for each in points(toy):
        found = curve_in_two(toy, each, over, span)
        assert found.values[0] == pytest.approx((each.parameter, 0.0), abs=1e-12)
        (value, to), code = found.values[-1], found.codes[-1]
        if to < last:  # right at zero, if another restitution decides what comes first
            assert found.points[-1].kind is PlaneKind.TWO_BORDERS
        elif any(abs(end.parameter - value) < CLOSE and end.kind is code for end in ends):
            met.add(each.id)
    assert {"PD1", "BC2"} <= met
    if name == "eps_n2":
        assert met == {"BC1", "PD1", "BC2", "FF1", "FF2", "BC3", "BC4", "BC5"}


def test_at_the_end_of_a_span_directions_turn_inside() -> None:
    """BC4 lies on the edge eps_n3 = 0: directions that lead out of a piece may leave the toys.

    Inside, the cycle's own piece lies there; the map at this place takes one of two others.
    """
    spans = (0.012, 1.0), (0.0, 5e-4)
    one, other = (Settings(span=span, window=(-2.5, -0.24)) for span in spans)
    map_ = Plane(ToyFamily(Toy(eps_n1=0.5), ("eps_n1", "eps_n3")), (one, other))
    x, p = np.array([-0.8847733440138271]), np.array([0.04532574146114695, 0.0])
    beside = map_.beside(x, p, np.array([-2.26, 0.0, -0.0125]))
    assert beside.value == pytest.approx(x, abs=CLOSE)
    outside = map_.beside(x, p, np.array([0.0, 0.0, -1.0]))
    assert outside.reason.startswith("eps_n3 must lie in [0, 1], got -")


def test_where_pieces_accumulate_no_curve_starts() -> None:
    drawn = random_toy(3)
    limit = SpecialPoint(
        id="BC1", kind=PointKind.BC, parameter=0.0025166179216093588, x=-1.0674841185392414,
        branches=(), order=1,
    )  # fmt: skip
    around = (0.0202, 0.0203)
    with pytest.raises(ValueError, match="at BC1 infinitely many pieces accumulate"):
        curve_in_two(drawn.toy, limit, (drawn.parameter, "h_s"), (drawn.span, around))


def test_flips_start_where_a_collision_has_the_multiplier_minus_one() -> None:
    found = curve("C")
    flip = next(point for point in found.points if PointKind.PD in point.starts)
    flips = curve_in_two(Toy(), flip, OVER, SPAN, kind="PD")
    assert flips.kind is PointKind.PD
    assert flips.values[0] == pytest.approx(flip.values, abs=CLOSE)
    assert np.nanmax(np.abs(flips.multipliers[1:, 0] + 1.0)) < 1e-6
    with pytest.raises(ValueError, match="kind must be one of PD"):
        curve_in_two(Toy(), flip, OVER, SPAN, kind="LP")


def test_a_fold_flip_becomes_a_collision_where_the_multiplier_passes_minus_one() -> None:
    """Wherever C's code changes a point is marked, though a word changes there, too."""
    found = curve("C")
    changes = [k for k in range(1, len(found)) if found.codes[k] is not found.codes[k - 1]]
    marked = [point.sample for point in found.points]
    assert changes
    assert all({k - 1, k} & set(marked) for k in changes)
    flip = next(point for point in found.points if abs(point.values[0] - 0.1934294) < 1e-6)
    assert flip.kind is PlaneKind.FLIP_BORDER
    assert max(flip.precision) < 1e-6  # as close as the first place beyond the word change lies


def test_flips_go_on_beyond_a_contact_with_another_curvature() -> None:
    """At (0.14647, 0.29336) they touch a border at which slopes go like a cube root.

    Beyond it their margin grows a thousand times slower than on this side. A place there is found
    again by continuation over one parameter.
    """
    toy = Toy(mu_2=0.2925, eps_n1=0.1386)
    found = continuation(toy, shoot(toy, -0.7704), "eps_n1", (0.138, 0.14))
    (flip,) = [point for point in found.points if point.kind is PointKind.PD]
    flips = curve_in_two(toy, flip, OVER, ((0.1, 0.9), (0.29, 0.34)))
    assert [end.kind for end in flips.ends] == [PlaneKind.FLIP_BORDER] * 2
    assert max(end.values[0] for end in flips.ends) > 0.149
    k = int(np.abs(flips.values[:, 0] - 0.148).argmin())
    eps_n1, mu_2 = flips.values[k].tolist()
    there, near = toy.replace(mu_2=mu_2, eps_n1=eps_n1 + 5e-5), (eps_n1 - 1e-4, eps_n1 + 1e-4)
    one = continuation(there, shoot(there, float(flips.x[k, 0])), "eps_n1", near)
    (anew,) = [point.parameter for point in one.points if point.kind is PointKind.PD]
    assert anew == pytest.approx(eps_n1, abs=CLOSE)


def test_wrong_arguments() -> None:
    toy, orbit = Toy(), shoot(Toy(), -0.53)
    point = diagram().point("A")
    with pytest.raises(TypeError, match="a special point over two"):
        continuation(toy, point, "eps_n1")  # type: ignore[call-overload]
    with pytest.raises(TypeError, match="a periodic solution is followed over one parameter"):
        continuation(toy, orbit, OVER, SPAN)  # type: ignore[call-overload]
    with pytest.raises(ValueError, match="span must be an interval of each of the two parameters"):
        continuation(toy, point, OVER, (0.0, 1.0))  # type: ignore[call-overload]
    with pytest.raises(TypeError, match="are for one parameter, not for two"):
        continuation(toy, point, OVER, SPAN, orders=(1,))  # type: ignore[call-overload]
    with pytest.raises(ValueError, match="there is no FF near eps_n1"):
        continuation(toy.replace(c_phi=0.006), point, OVER, SPAN)  # the same as curve_in_two


@pytest.mark.nightly
def test_folds_end_where_the_margin_of_a_grazing_does_not_change_with_the_angle() -> None:
    """There the infinite slope at the border changes its sign, and its collision from a fold."""
    toy, names = Toy(l_s=0.0207, eps_n1=0.22), ("eps_n1", "l_s")
    span = (0.0, 1.0), (0.0195, 0.0207)
    diagram = continuation(toy, shoot(toy, -0.624), span=(0.215, 0.225))
    (fold,) = [each for each in diagram.points if each.kind is PointKind.LP]
    (border,) = [each for each in diagram.points if each.note == "fold"]
    folds, collisions = (curve_in_two(toy, each, names, span) for each in (fold, border))
    ends = [
        [each.values for each in curve.points if each.kind is PlaneKind.DEGENERATE_GRAZING]
        for curve in (folds, collisions)
    ]
    assert ends[0] == [pytest.approx((0.22565369, 0.0204754827), rel=1e-7)]
    assert ends[0][0] == pytest.approx(ends[1][0], rel=1e-7)
    # followed on the side with a finite slope, the border leads on to where another one is met
    assert collisions.ends[0].kind is PlaneKind.TWO_BORDERS
    assert collisions.ends[0].values == pytest.approx((0.279174716, 0.019562023), rel=1e-7)
    assert {each.status for each in collisions.points} == {PointStatus.LOCATED}


@pytest.mark.nightly
@pytest.mark.parametrize("spans", [(0.019, 0.0222), (0.02, 0.0215)])
def test_a_curve_goes_on_where_the_beak_strikes_at_the_angle_of_the_sleeve(
    spans: tuple[float, float],
) -> None:
    """(l_M + l_G - l_S - r_0)/h_S = (r_M - r_0)/h_M: both strike from then on, and margins of three
    borders vanish at once. One of them has a derivative 0/0 there, or not, as spans are rounded.
    """
    toy = Toy()
    meet = toy.l_m + toy.l_g - toy.r_0 - toy.h_s * (toy.r_m - toy.r_0) / toy.h_m
    curve = curve_in_two(toy, island_ends(toy)["I1"], ("eps_n1", "l_s"), ((0.0, 1.0), spans))
    assert curve.values[:, 1].max() > 0.0209 > meet
    assert np.abs(curve.values - (0.40415561, meet)).max(axis=1).min() < 1e-8


@pytest.mark.nightly
def test_a_corner_is_passed_where_slopes_merge_like_a_cube_root() -> None:
    """At (0.22998588, 0.020226783) the upper sleeve only just stays, too: slopes differ by 1.3 at a
    distance of 1e-11 from this second border, and by 2.15 times as much ten times further away."""
    near = bifurcation_diagram(Toy(), "eps_n1", (0.233, 0.234), (1,), (-1.75, -1.6))
    (point,) = [each for each in near.points if each.kind is PointKind.BC]
    found = curve_in_two(Toy(), point, ("eps_n1", "l_s"), ((0.0, 1.0), (0.02005, 0.02024)))
    assert {each.status for each in found.points} == {PointStatus.LOCATED}
    corners = [each.values[1] for each in found.points if each.kind is PlaneKind.TWO_BORDERS]
    assert corners == [pytest.approx(0.020215608)]
    changes = [each.first for each in found.words]
    assert min(abs(found.values[changes, 1] - 0.0202267823)) < 1e-9
