"""Regions of the plane with exact borders: closed forms of the skew tent map, and its raster."""

import pytest
import sympy

from pwmap import PiecewiseLinearMap, parameter_plane
from pwmap.plane import ParameterPlane, PlaneRegion, plane_raster

A = sympy.Symbol("a")
SKEW = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")


@pytest.fixture(scope="module")
def plane() -> ParameterPlane:
    return parameter_plane(SKEW, "a", "b", ("1/10", "11/10"), (-5, "-1/2"), orders=(1, 2, 3))


def test_period_three_of_the_skew_tent_map(plane: ParameterPlane) -> None:
    """L L R is admissible for b < -(1 + 1/a) and attracts while a^2 b > -1.

    Both curves meet at the golden ratio; where a^2 b = -1 leaves the rectangle, a = 5^(-1/2).
    """
    left, right = plane.regions(period=3)
    golden, root = (sympy.sqrt(5) - 1) / 2, 1 / sympy.sqrt(5)
    assert sympy.simplify(sympy.Matrix([*left.across, *right.across])) == sympy.Matrix(
        [sympy.Rational(1, 4), root, root, golden]
    )
    assert [sympy.expand(each) for each in left.along] == [-5, -1 - 1 / A]
    assert [sympy.expand(each) for each in right.along] == [-(A**-2), -1 - 1 / A]
    assert {*left.words, *right.words} == {"LLR"}


@pytest.mark.nightly
def test_regions_fill_the_rectangle_as_a_raster_has_it(plane: ParameterPlane) -> None:
    raster = plane_raster(plane, 12, 10)
    for column, a in enumerate(raster.across):
        for row, b in enumerate(raster.along):
            (region,) = [each for each in plane.regions() if holds(each, a, b)]
            assert min(region.periods, default=0) == raster.periods[row, column]


def holds(region: PlaneRegion, a: object, b: object) -> bool:
    at = sympy.Rational(str(a))
    low, high = (each.subs(A, at) for each in region.along)
    return bool(region.across[0] < at < region.across[1] and low < sympy.Rational(str(b)) < high)
