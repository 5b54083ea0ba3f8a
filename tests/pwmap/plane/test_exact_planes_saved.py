"""Exact planes saved and loaded: the same in all they hold; files that were changed are refused."""

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
import sympy
from same import differences
from sympy import QQ, Rational
from tampering import changed_file
from tampering import refusal as refused_file

from pwmap import Budget, PiecewiseLinearMap, UndecidedError, load_diagram, parameter_plane
from pwmap.algebra.exact import HIGHEST, LOWEST, polynomial_ring
from pwmap.algebra.roots import RealRoot, real_roots
from pwmap.diagrams import formulas
from pwmap.plane import ParameterPlane, load_plane, with_crises
from pwmap.plot import plot_plane

A, B = sympy.symbols("a b")
SKEW = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (b*x + 1, True))")
SPANS = ("1/10", "11/10"), (-5, "-1/2")


@cache
def with_algebraic_ends() -> ParameterPlane:
    """Strips end at 1/sqrt(5) and at the golden ratio, where curves of period three meet."""
    return parameter_plane(SKEW, "a", "b", *SPANS, orders=(1, 2, 3))


@cache
def with_curved_cells() -> ParameterPlane:
    """Along a, edges of cells are roots of degree three in it: these cells have columns."""
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - a*x, True))")
    return parameter_plane(map_, "r", "a", (-1, 3), ("1/2", 3), orders=(1, 2, 3, 4))


@cache
def with_assumptions() -> ParameterPlane:
    """Conditions, a denominator, and symbols that are known to be positive."""
    a, r = sympy.symbols("a r", positive=True)
    x = sympy.Symbol("x")
    pieces = [(r / (1 + a) - 2, x <= 0), (r - a * x, x > 0)]
    map_ = PiecewiseLinearMap(pieces, x, given=[a > 1, r < 4])
    return parameter_plane(map_, a, r, (Rational(3, 2), 3), (1, 3))


@cache
def with_crisis() -> ParameterPlane:
    """A curve of merging crises, which no strip holds."""
    plane = parameter_plane(SKEW, "a", "b", ("19/20", 1), ("-17/10", "-8/5"), orders=(1,))
    return with_crises(plane, order=1, columns=1)


@cache
def broken_off() -> ParameterPlane:
    """What is left of a rectangle after some work, with the sentence that says so."""
    plane = parameter_plane(SKEW, "a", "b", *SPANS, (1, 2, 3), budget=Budget(work=20_000))
    assert plane.left_out
    return plane


@cache
def of_a_cell() -> ParameterPlane:
    """The plane of a map that holds in a cell only."""
    (*_, whole) = parameter_plane(SKEW, "a", "b", ("1/4", "3/4"), (-5, "-1/2")).strips
    cell = next(each for each in whole.cells if each.upper == -1 and not each.is_edge)
    return parameter_plane(cell.map, "a", "b", ("1/3", "1/2"), ("-2", "-3/2"))


PLANES = (
    pytest.param(with_algebraic_ends, marks=pytest.mark.slow), with_curved_cells, with_assumptions,
    with_crisis, broken_off, of_a_cell,
)  # fmt: skip


@pytest.mark.parametrize("made", PLANES, ids=lambda made: made.__name__)
def test_what_is_loaded_is_what_was_saved_and_answers_as_that(
    made: Callable[[], ParameterPlane], tmp_path: Path
) -> None:
    plane = made()
    path = plane.save(tmp_path / "plane.json")
    loaded = load_plane(path)
    for name in ("across", "along", "across_span", "along_span", "left_out", "curves", "points"):
        assert differences(getattr(plane, name), getattr(loaded, name)) == [], name
    assert repr(loaded) == repr(plane)
    assert (repr(loaded.map), str(loaded.map)) == (repr(plane.map), str(plane.map))
    assert loaded.regions() == plane.regions()
    assert loaded.points_to_dataframe().equals(plane.points_to_dataframe())
    for one, other in zip(plane.strips, loaded.strips, strict=True):
        for name in ("column", "borders", "marks", "upright"):
            assert differences(getattr(one, name), getattr(other, name)) == [], name
        assert (one.cells.given, one.cells.orders) == (other.cells.given, other.cells.orders)
        for cell, again in zip(one.cells, other.cells, strict=True):
            assert (cell.lower, cell.upper) == (again.lower, again.upper)
            assert again.map.scope == cell.map.scope
            assert again.map.iterates == cell.map.iterates
            assert again.map.oracle.signs == cell.map.oracle.signs
    assert load_plane(plane.save(tmp_path / "plane.json.gz")).save(path).stat().st_size > 0
    middle = [(low + high) / 2 for low, high in (plane.across_span, plane.along_span)]
    exact = [QQ.to_sympy(value) for value in middle]
    assert str(loaded.at(*exact)) == str(plane.at(*exact))
    for one, other in zip(plane.curves, loaded.curves, strict=True):
        assert other.along(exact[0]) == one.along(exact[0])
    for cell, again in zip(plane.strips[0].cells, loaded.strips[0].cells, strict=True):
        for order in plane.strips[0].cells.orders:
            first, second = cell.map.iterate(order), again.map.iterate(order)
            assert second.fixed_points() == first.fixed_points()
            assert second.jump_crossings() == first.jump_crossings()
        assert refusal(again.map) == refusal(cell.map)  # what was not decided is not decided now
    assert list(plot_plane(loaded, samples=10).artists) == list(
        plot_plane(plane, samples=10).artists
    )


def refusal(map_: PiecewiseLinearMap) -> str:
    """Why an iterate that a cell was not cut for is refused; nothing if it is not."""
    try:
        map_.iterate(5).fixed_points()
    except UndecidedError as error:
        return str(error)
    return ""


def test_exact_numbers_keep_their_values() -> None:
    ring = polynomial_ring((A, B))
    a, b = ring.gens
    root = real_roots((QQ(1), QQ(0), QQ(-3), QQ(1)))[1]  # of x**3 - 3*x + 1, near 0.347
    assert isinstance(root, RealRoot)
    for value in (
        QQ(-7, 3), QQ(3**9000, 2), root, LOWEST, HIGHEST, ring, ring.zero, 2 * a * b**2 + QQ(1, 3),
    ):  # fmt: skip
        again = formulas.from_plain(json.loads(json.dumps(formulas.to_plain(value))))
        assert again == value
        assert type(again) is type(value)
    again = formulas.from_plain(formulas.to_plain(root))
    assert QQ(347, 1000) < again < QQ(348, 1000)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (["RealRoot", ["1", "0", "-2"], 1, "2", "3"], "expected ends on both sides of a root"),
        (["RealRoot", ["1", "0", "-2"], "1", "1", "2"], "expected the number of a root, got '1'"),
        (["Infinite", 3], "expected an infinity by its side -1 or 1, got 3"),
    ],
)
def test_numbers_that_are_none_are_refused(data: object, message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        formulas.from_plain(data)


def test_the_numbers_of_a_file_are_texts(tmp_path: Path) -> None:
    content = json.loads(with_algebraic_ends().save(tmp_path / "plane.json").read_bytes())
    assert list(content) == ["format", "version", "seal", "plane"]
    assert (content["format"], content["version"]) == ("pwmap plane", 1)
    plane = content["plane"]
    assert plane["across_span"] == [{"$formula": ["QQ", "1/10"]}, {"$formula": ["QQ", "11/10"]}]
    ends = plane["strips"][0]["column"]
    assert ends["high"] == {"$formula": ["QQ", "1/5"]}
    algebraic = [s["column"]["high"]["$formula"] for s in plane["strips"]]
    assert [each[1] for each in algebraic if each[0] == "RealRoot"] == [
        ["1", "0", "-1/5"], ["1", "1", "-1"]
    ]  # fmt: skip
    # each decision and each iterate once, however many cells share it
    assert len(plane["signs"]) == len({json.dumps(each) for each in plane["signs"]})
    assert len(plane["signs"]) < sum(
        len(cell["map"]["signs"]) for strip in plane["strips"] for cell in strip["cells"]["cells"]
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: c["plane"]["curves"][0].update(id="BC7"), "its content was changed after it"),
        (lambda c: c["plane"]["signs"][0].__setitem__(1, 0), "its content was changed after it"),
        (lambda c: c.pop("seal"), "its content was changed after it was saved"),
        (lambda c: c.pop("plane"), "'plane'"),
        (lambda c: c.update(format="pwmap diagram"), "it does not begin with the format 'pwmap pl"),
        (lambda c: c.update(version=0), "a whole number from 1 on, got 0"),
    ],
)
def test_changed_files_are_refused_in_one_sentence(
    change: Callable[[dict], object], message: str, tmp_path: Path
) -> None:
    path = changed_file(with_crisis().save(tmp_path / "plane.json"), change)
    assert message in refused_file(load_plane, path)


def test_another_record_is_no_plane(tmp_path: Path) -> None:
    path = with_crisis().save(tmp_path / "plane.json")
    assert "saved diagram: it does not begin with the format" in refused_file(load_diagram, path)
    with pytest.raises(FileNotFoundError):
        load_plane(tmp_path / "none.json")
