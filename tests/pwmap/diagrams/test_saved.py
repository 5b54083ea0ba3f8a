"""Diagrams saved and loaded: the same in all they hold; files that are none are refused."""

import dataclasses
import gzip
import json
import math
from collections.abc import Callable
from pathlib import Path

import networkx as nx
import numpy as np
import numpy.typing as npt
import pytest
import sympy
from effort import at_most
from same import differences
from sympy import Integer, Rational, sqrt
from tampering import changed_file, refusal
from test_diagram import diagram as with_open_point

from pwmap import (
    Branch,
    Diagram,
    PiecewiseLinearMap,
    SpecialPoint,
    attractor_diagram,
    bifurcation_diagram,
    load_diagram,
    prove,
)
from pwmap.algebra.rootfunctions import RealRootOf
from pwmap.diagrams import formulas
from pwmap.diagrams.encoding import from_plain, to_plain
from pwmap.diagrams.tables import FILES, write_results
from pwmap.longrun import with_attractors

A, R, X = sympy.symbols("a r x")
P1L = "Piecewise((r - 2, x <= 0), (r - a*x, True))"


def symbolic() -> Diagram:
    """Exact values are formulas in a > 1."""
    map_ = PiecewiseLinearMap.from_sympy(sympy.sympify(P1L), X, given=[A > 1])
    return bifurcation_diagram(map_, "r", (-1, 2), orders=(1, 2, 3))


def with_roots() -> Diagram:
    """Special points at roots of polynomials, such as CRootOf(t**3 - 3*t**2 + 3*t - 3, 0)."""
    map_ = PiecewiseLinearMap.from_sympy(sympy.sympify(P1L), X).at({R: 3})
    return bifurcation_diagram(map_, "a", (Rational(11, 10), 4), orders=(1, 2, 3))


def with_infinities() -> Diagram:
    """Points at infinity, and intervals of fixed points along single values of the parameter."""
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((a*x + 1, x <= 0), (a*x - 1, True))")
    return bifurcation_diagram(map_, "a", (-2, 2), orders=(1, 2, 3))


def with_bands() -> Diagram:
    """Bands that merge at sqrt(2), with columns of their own."""
    tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    found = bifurcation_diagram(tent, "a", ("6/5", "9/4"), (1, 2))
    return with_attractors(found, attractor_diagram(tent, "a", ("6/5", "9/4"), 2))


DIAGRAMS = (symbolic, with_roots, with_infinities, with_bands, with_open_point)


def shown(diagram: Diagram, value: float) -> list[tuple[str, str]]:
    """What a diagram shows at a value of the parameter, to the last bit."""
    return [(hit.branch.id, repr(tuple(hit)[1:])) for hit in diagram.at(value)]


@pytest.mark.slow
@pytest.mark.parametrize("made", DIAGRAMS, ids=lambda made: made.__name__)
@pytest.mark.parametrize("name", ["diagram.json", "diagram.json.gz"])
def test_what_is_loaded_is_what_was_saved(
    made: Callable[[], Diagram], name: str, tmp_path: Path
) -> None:
    diagram = made()
    path = diagram.save(tmp_path / name)
    loaded = load_diagram(path)
    assert path == tmp_path / name
    assert differences(diagram, loaded) == []
    assert (loaded, hash(loaded)) == (diagram, hash(diagram))
    first, second = diagram.graph(), loaded.graph()
    assert nx.utils.graphs_equal(first, second)
    for point in diagram.points:
        assert loaded.sides(point.id) == diagram.sides(point.id)
    for value in {point.parameter for point in diagram.points} | {1.25}:
        assert shown(loaded, value) == shown(diagram, value)
    for branch in loaded.branches:
        assert not branch.x.flags.writeable
        assert branch.stable.tolist() == diagram.branch(branch.id).stable.tolist()


def test_diagrams_are_equal_by_value(tmp_path: Path) -> None:
    """Also where nan stands; another last bit of a sample, or another formula, is another one."""
    diagram = with_open_point()
    assert load_diagram(diagram.save(tmp_path / "d.json")) == diagram
    branch, *others = diagram.branches
    assert any(math.isnan(m) for each in diagram.branches for m in each.multiplier)
    x = [math.nextafter(branch.x[0], math.inf), *branch.x[1:]]
    for changed in (
        dataclasses.replace(branch, x=x), dataclasses.replace(branch, exact={"x": A}),
    ):  # fmt: skip
        assert dataclasses.replace(diagram, branches=(changed, *others)) != diagram
    assert diagram != "diagram"


def test_the_file_is_plain_json(tmp_path: Path) -> None:
    path = with_open_point().save(tmp_path / "small.json")
    content = json.loads(path.read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert list(content) == ["format", "version", "diagram"]
    assert (content["format"], content["version"]) == ("pwmap diagram", 1)
    branches = content["diagram"]["branches"]
    assert branches[0]["parameter"] == [0.1, 0.2, 0.4]
    assert branches[0]["words"][1]["cause"] == "the upper sleeve grazes"
    assert content["diagram"]["points"][2]["precision"] == {"$numberDouble": "inf"}


@pytest.mark.parametrize(
    ("values", "kind"),
    [
        ([0.0, -0.0, math.nan, math.inf, -math.inf, 5e-324], np.float64),
        ([[1, -2], [3, 0]], np.int64),
        ([True, False], np.bool_),
    ],
)
def test_arrays_come_back_to_the_last_bit(values: list[object], kind: type[np.generic]) -> None:
    made = np.array(values, dtype=kind)
    again = from_plain(json.loads(json.dumps(to_plain(made))), npt.NDArray[kind])
    assert (again.dtype, again.shape, again.tobytes()) == (made.dtype, made.shape, made.tobytes())


def test_values_of_any_type(tmp_path: Path) -> None:
    """What a mapping without types holds: values of JSON, numbers it lacks, formulas."""
    made = {
        "toy": {"pole": math.inf, "eps_n1": 0.5}, "span": [0.0, 1], "law": "summed", "x": A / 2,
        "known": None, "flag": True,
    }  # fmt: skip
    diagram = dataclasses.replace(with_open_point(), sample=made)
    loaded = load_diagram(diagram.save(tmp_path / "d.json"))
    assert loaded.sample == made
    assert isinstance(loaded.sample["x"], sympy.Mul)


@pytest.mark.parametrize(
    "value",
    [
        Rational(-7, 3), sympy.oo, -sympy.oo, sympy.nan, sqrt(2),
        (1 + sqrt(5)) / 2, sympy.Mul(2, A + 1, evaluate=False), A**-2 * (R - 2) ** 3,
        sympy.CRootOf(X**5 - X - 1, 0), sympy.CRootOf(X**3 - 2, 0) + 1,
        RealRootOf(A * R**3 + 1, R, Integer(0)), RealRootOf(R**5 - A * R - 1, R, Integer(2)) ** 2,
        sympy.Symbol("a", positive=True) + A, sympy.Interval.Lopen(A, sympy.oo),
        sympy.FiniteSet(1, sqrt(2)), sympy.Union(sympy.Interval(0, 1), sympy.Interval(2, 3)),
    ],
)  # fmt: skip
def test_formulas_keep_their_form(value: sympy.Basic) -> None:
    data = json.loads(json.dumps(formulas.to_plain(value)))
    again = formulas.from_plain(data)
    assert again == value
    assert (str(again), hash(again)) == (str(value), hash(value))


def test_other_formulas_are_refused() -> None:
    for value in (sympy.sin(A), sympy.Dummy("a")):
        with pytest.raises(TypeError, match="expected an algebraic formula or a set of such, got"):
            formulas.to_plain(value)


def test_every_field_is_in_the_file(tmp_path: Path) -> None:
    content = json.loads(with_open_point().save(tmp_path / "d.json").read_bytes())["diagram"]
    for kind, data in (
        (Diagram, content),
        (Branch, content["branches"][0]),
        (SpecialPoint, content["points"][0]),
    ):
        assert list(data) == [each.name for each in dataclasses.fields(kind) if each.init]


def test_an_older_file_without_a_field_has_its_default(tmp_path: Path) -> None:
    def older(content: dict) -> None:
        for data in content["diagram"]["branches"]:
            del data["columns"], data["attracts"]

    path = changed_file(with_open_point().save(tmp_path / "d.json"), older)
    assert differences(with_open_point(), load_diagram(path)) == []


def exact_x(content: dict, formula: object) -> None:
    """Put a formula for the exact place of a point."""
    content["diagram"]["points"][0]["exact"] = {"x": {"$formula": formula}}


def exact_branch(content: dict, exact: dict) -> None:
    """Put exact values in a branch, of which lists are formulas."""
    content["diagram"]["branches"][0]["exact"] = {
        name: {"$formula": value} if isinstance(value, list) else value
        for name, value in exact.items()
    }


def exact_stretch(content: dict, exact: dict) -> None:
    """Put exact values in a later stretch of a branch."""
    content["diagram"]["branches"][0]["words"][1]["exact"] = exact


P = ["Symbol", "eps_n1"]  # the parameter of the diagram
UNIT = ["Interval", "0", "1", True, True]
NO_VALUES = [  # with which a slice of such a diagram failed later, with errors of other libraries
    ({"x": "foo"}, "the exact 'x' of branch 'b1' must be an algebraic expression, got 'foo'"),
    ({"x": 0.5}, "the exact 'x' of branch 'b1' must be an algebraic expression, got 0.5"),
    ({"x": None}, "the exact 'x' of branch 'b1' must be an algebraic expression, got None"),
    ({"x": ["Symbol", "q"]}, "the exact 'x' of branch 'b1' must be an expression in eps_n1, got q"),
    ({"multiplier": ["Add", P, ["Symbol", "q"]]}, "in eps_n1, got eps_n1 + q with the unknown q"),
    ({"x": UNIT}, "must be an algebraic expression, got Interval.open(0, 1)"),
    ({"x": ["Gt", P, "1"]}, "must be an algebraic expression, got eps_n1 > 1"),
    ({"x": ["Pow", "2", P]}, "must be an algebraic expression, got 2**eps_n1"),
    ({"x": "zoo"}, "must be an algebraic expression, got 'zoo'"),
    ({"x": ["QQ", "5/4"]}, "the exact 'x' of branch 'b1' must be an algebraic expression, got "),
    ({"interval": P, "x": P}, "'interval' of branch 'b1' must be an interval or a value, got eps"),
    ({"interval": ["Interval", "0", P, True, True], "x": P}, "must be an expression without symb"),
    ({"interval": UNIT}, "of branch 'b1' must have x, or lower and upper, got interval"),
]
NO_FORMULAS = [
    (["exec", "1"], "'exec'"),
    (["Interval", "0", "1", 0, 1], "whether the ends of an interval are open, got [0, 1]"),
    (["Interval", "0", "1", True], "whether the ends of an interval are open, got [True]"),
    (["CRootOf", ["1", "0", "-2"], ["Add", ["Symbol", "t"], "1"], 0], "a root by its symbol"),
    (["CRootOf", ["1", "0", "-2"], ["Symbol", "t"], True], "a root by its symbol and number"),
    (["CRootOf", ["1", "0", "-2"], ["Symbol", "t"], 2], "is no saved diagram"),
    (["CRootOf", ["1/2", "0", "x"], ["Symbol", "t"], 0], "is no saved diagram"),
    (["CRootOf", [], ["Symbol", "t"], 0], "is no saved diagram"),
    (["CRootOf", "12", ["Symbol", "t"], 0], "is no saved diagram"),
    (["CRootOf"], "is no saved diagram"),
    (["RealRootOf", ["Symbol", "a"], "2", 0], "a root by its symbol and number, got 2 and 0"),
    (["RealRootOf", ["Symbol", "a"], ["Symbol", "b"]], "is no saved diagram"),
    (["Pow", "2"], "is no saved diagram"),
    (["Union", "2"], "is no saved diagram"),
]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: c.update(format="pwmap atlas"), "it does not begin with the format"),
        (lambda c: c.pop("diagram"), "'diagram'"),
        (lambda c: c["diagram"]["points"].pop(), "branch 'j1' ends at unknown point 'EP1'"),
        (lambda c: c["diagram"].update(points=3), "expected list, got int"),
        (lambda c: c["diagram"].update(x_name=3), "expected str, got int"),
        (lambda c: c["diagram"].update(colour=3), "Diagram has no colour"),
        (lambda c: c["diagram"]["branches"][0].update(order=True), "expected int, got bool"),
        (lambda c: c["diagram"]["branches"][0].update(kind="arc"), "'arc' is not a valid"),
        (lambda c: c["diagram"]["branches"][0]["x"].pop(), "must have one common length"),
        (lambda c: c["diagram"]["branches"][0].update(x=[None] * 3), "expected a number, got None"),
        *(
            (lambda c, v=v: c.update(version=v), f"a whole number from 1 on, got {v!r}")
            for v in (-1, 0, True, 1.0, "1", None, [1])
        ),
        *((lambda c, f=f: exact_x(c, f), message) for f, message in NO_FORMULAS),
        (lambda c: exact_x(c, P), "the exact 'x' of point 'LP1' must be an expression without"),
        *((lambda c, e=e: exact_branch(c, e), message) for e, message in NO_VALUES),
        (
            lambda c: exact_stretch(c, {"x": "1/0"}),
            "the exact 'x' of branch 'b1', stretch 1 must be an algebraic expression, got '1/0'",
        ),
    ],
)
def test_files_that_are_none_are_refused(
    change: Callable[[dict], object], message: str, tmp_path: Path
) -> None:
    path = changed_file(with_open_point().save(tmp_path / "d.json"), change)
    assert message in refusal(load_diagram, path)


def test_a_newer_version_is_refused_in_one_sentence(tmp_path: Path) -> None:
    path = changed_file(with_open_point().save(tmp_path / "d.json"), lambda c: c.update(version=2))
    with pytest.raises(ValueError, match="newer one is needed") as refused:
        load_diagram(path)
    assert str(refused.value) == (
        f"{path} has version 2 of the format 'pwmap diagram', and this pwmap reads up to version "
        "1: a newer one is needed"
    )


@pytest.mark.parametrize(
    "content",
    [b"", b"{", b"[1]", b"\xff\xfe", b"[" * 100_000, gzip.compress(b"{}", mtime=0), b"graph {}"],
)
def test_other_files_are_refused(content: bytes, tmp_path: Path) -> None:
    for name in ("d.json", "d.json.gz"):
        path = tmp_path / name
        path.write_bytes(content)
        refusal(load_diagram, path)


def test_a_file_that_is_cut_off_is_refused(tmp_path: Path) -> None:
    for name in ("d.json", "d.json.gz"):
        path = with_open_point().save(tmp_path / name)
        path.write_bytes(path.read_bytes()[:-20])
        refusal(load_diagram, path)


@pytest.mark.parametrize("name", ["d", "d.json", "d.json.gz", "d.gz", "D.JSON", "D.GZ", "a=0.5"])
def test_names_of_saved_files(name: str, tmp_path: Path) -> None:
    path = with_open_point().save(tmp_path / name)
    assert load_diagram(path) == with_open_point()
    assert path.read_bytes().startswith(b"\x1f\x8b" if name.lower().endswith("gz") else b"{")


@pytest.mark.parametrize("name", ["d.csv", "d.json.zip", "d.0x5"])
def test_a_name_of_another_format_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=f"expected a name in .json or .json.gz, got '{name}'"):
        with_open_point().save(tmp_path / name)
    with pytest.raises(ValueError, match=f"expected a name in .json, got '{name}'"):
        prove(PiecewiseLinearMap.from_sympy("x/2")).save(tmp_path / name)
    assert not any(tmp_path.iterdir())


def test_nothing_is_half_written(tmp_path: Path) -> None:
    path = with_open_point().save(tmp_path / "d.json")
    before = path.read_bytes()
    wrong = dataclasses.replace(with_open_point(), sample={"a": sympy.sin(A)})
    with pytest.raises(TypeError, match="expected an algebraic formula"):
        wrong.save(path)
    assert path.read_bytes() == before
    assert [each.name for each in tmp_path.iterdir()] == ["d.json"]
    with pytest.raises(FileNotFoundError, match="there is no folder"):
        wrong.__class__(parameter_name="p", x_name="x", branches=(), points=()).save(
            tmp_path / "none" / "d.json"
        )
    with pytest.raises(IsADirectoryError, match="it is a folder, expected a file in it"):
        with_open_point().save(tmp_path)
    with pytest.raises(FileNotFoundError):
        load_diagram(tmp_path / "none.json")


def test_results_in_a_folder_hold_the_diagram(tmp_path: Path) -> None:
    write_results(with_open_point(), tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(FILES)
    assert differences(with_open_point(), load_diagram(tmp_path / "diagram.json")) == []


# --- Files that ask for too much ------------------------------------------------------------------


def with_formula(formula: object, path: Path) -> Path:
    return changed_file(with_open_point().save(path), lambda c: exact_x(c, formula))


def test_a_small_file_that_holds_a_large_one_is_refused(tmp_path: Path) -> None:
    """Two megabytes could hold two gigabytes; what is saved here is at most 25 times denser."""
    path = tmp_path / "d.json.gz"
    path.write_bytes(gzip.compress(b"[" + b"0," * 10_000_000 + b"0]"))
    with pytest.raises(ValueError, match=r"is no saved diagram: \d+ bytes of it hold more than 16"):
        load_diagram(path)


def test_roots_that_would_take_long_are_refused_before_they_do(tmp_path: Path) -> None:
    """A product of two polynomials with numbers of 4 000 digits: some 10 s to tell its roots apart.

    Many roots that take a second each are as bad.
    """
    t = sympy.Symbol("t")
    for digits, count in ((4000, 1), (400, 100)):
        product = (10**digits * t**3 - t - 1) * (10**digits * t**2 - 3)
        coefficients = [hex(int(each)) for each in sympy.Poly(product, t).all_coeffs()]
        root = ["CRootOf", coefficients, ["Symbol", "t"], 0]
        path = with_formula(["Add", *[root] * count], tmp_path / "d.json")
        refused = pytest.raises(ValueError, match="formulas have numbers so long that they are not")
        with at_most(20_000), refused:
            load_diagram(path)


@pytest.mark.nightly
def test_sets_of_many_intervals_are_read_as_they_are(tmp_path: Path) -> None:
    """Sorted and joined again they would take half a minute."""
    parts = [["Interval", str(2 * k), str(2 * k + 1), True, False] for k in range(1500)]
    with at_most(4_000_000):
        found = formulas.from_plain(["Union", *parts])
    assert len(found.args) == 1500
