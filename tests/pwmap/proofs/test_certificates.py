"""Certificates of maps: what they prove is true, and nothing else passes the checker."""

import json
import random
import shutil
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import certified
import independent
import pytest
from certified import (
    at,
    canonical,
    changed,
    followed,
    paths,
    random_map,
    refused,
    refused_claims,
    replaced,
    sealed,
    without,
)
from families import Draw
from readings import rational_near
from tampering import changed_texts

import pwmap
from pwmap import PiecewiseLinearMap, attractor_diagram, bifurcation_diagram, prove
from pwmap.checking import check, check_certificate
from pwmap.checking.certificate import FIXED_POINTS, FORMAT
from pwmap.longrun import with_attractors
from pwmap.proofs import Certificate, Refused

P1L = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - a*x, True))", given=["a > 1"])
TENT = PiecewiseLinearMap.from_sympy("Piecewise((s*x, x <= 1/2), (s*(1 - x), True))")
CHECKER = Path(pwmap.__file__).parent / "checking"


# --- The paper's map ------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [1, 2, 3, 4, 7])
@pytest.mark.parametrize(("a", "r"), [("5/4", "1"), ("7/5", "1/3"), ("3", "19/10")])
def test_facts_of_the_paper_are_proved(a: str, r: str, order: int) -> None:
    """Fixed points r - 2 and r/(1 + a), one jump crossing at x* (1 - (-a)^(1 - j))."""
    content = prove(P1L.at({"a": a, "r": r}), order=order).content
    slope, offset = Fraction(a), Fraction(r)
    star = offset / (1 + slope)
    assert content["fixed points"] == [
        {"word": "L" * order, "x": str(offset - 2), "slope": "0", "period": 1, "stable": True},
        {"word": "R" * order, "x": str(star), "slope": str((-slope) ** order), "period": 1,
         "stable": False},
    ]  # fmt: skip
    assert content["intervals"] == []
    (jump,) = content["crossings"]
    assert Fraction(jump["x"]) == star * (1 - (-slope) ** (1 - order))
    assert {jump["left"], jump["right"]} == {str(offset), str(offset - 2)}


def test_the_sentence_says_it_all() -> None:
    assert prove(P1L.at({"a": "5/4", "r": 1}), order=2).statement == (
        "For the map with the pieces L: -1 for x <= 0; R: -5/4 x + 1 for 0 < x, all that the "
        "iterate P_2 has on the diagonal is: 2 single fixed points: -1 (word LL, slope 0, "
        "attracting), 4/9 (word RR, slope 25/16, not attracting); no intervals of fixed points; "
        "1 jump with limits strictly on both sides of it: 4/5 (from 1 to -1, words RR|RL)."
    )


def fold_flip() -> Certificate:
    map_ = P1L.at({"a": "5/4"})
    return prove(bifurcation_diagram(map_, "r", (-1, 3), (1, 2)), map_)


def test_the_fold_flip_is_proved_with_its_signs() -> None:
    found = fold_flip()
    assert found.content["points"] == [
        {"edge": 1, "x": "0", "code": "FF", "note": "fold",
         "conditions": [{"word": "R", "side": 1, "vanishing": [["0", "1"]], "simple": [True]}],
         "signs": [1, 1, -1]},
        {"edge": 2, "x": "0", "code": "BC", "note": "fold",
         "conditions": [{"word": "L", "side": -1, "vanishing": [["-2", "1"]], "simple": [True]}],
         "signs": [-1, 1, 1]},
    ]  # fmt: skip
    assert found.statement == (
        "For the map with the pieces L: (-2 + r) for x <= 0; R: -5/4 x + r for 0 < x and every r "
        "strictly between -1 and 3, the lists hold all that the iterates P_j with j = 1, 2 have on "
        "the diagonal: fixed points of least period j (3 stretches, with x, slope and stability), "
        "intervals of such points (no stretches), and jumps with limits strictly on both sides of "
        "it (3 stretches, with x and both limits); inside, single fixed points begin and end only "
        "at 2 special points: FF, fold, at r = 0 and x = 0; BC, fold, at r = 2 and x = 0."
    )


def tent() -> Certificate:
    return prove(bifurcation_diagram(TENT, "s", (0, 3), (1, 2, 3)), TENT)


@pytest.mark.nightly
def test_points_at_algebraic_values_are_proved() -> None:
    """Period three of the tent map begins at the golden mean; at s = 1 there is an interval."""
    content = tent().content
    assert content["edges"] == [
        "0", "1", {"polynomial": ["-1", "-1", "1"], "interval": ["3/2", "2"]}, "3",
    ]  # fmt: skip
    assert [p["edge"] for p in content["points"] if p["note"] == "fold"] == [1, 2, 2, 2]
    assert content["intervals"] == [{"order": 1, "word": "L", "places": [2, 2]}]


def quotients() -> Certificate:
    map_ = PiecewiseLinearMap.from_sympy(
        "Piecewise((x/(1 + p**2) - 1/(2 + p), x < p), (1 - p*x/(2 + p), True))", given=["p > -1"]
    )
    return prove(bifurcation_diagram(map_, "p", (0, 2), (1, 2)), map_)


# --- Random maps ----------------------------------------------------------------------------------


@pytest.mark.nightly
@pytest.mark.parametrize("seeds", [range(k, k + 75) for k in range(0, 300, 75)], ids=str)
def test_random_maps_agree_with_brute_force(seeds: range) -> None:
    kinds = set()
    for seed in seeds:
        f, order = random_map(seed), seed % 4 + 1
        found = prove(certified.read(f), order=order)
        assert check(found.content) == found.statement
        assert found.content["map"] == certified.written(f)
        expected = followed(f, order)
        assert {key: found.content[key] for key in expected} == expected, seed
        kinds |= {key for key, rows in expected.items() if rows}
        kinds |= {"point" for row in expected["fixed points"] if row["slope"] is None}
    assert kinds == {"fixed points", "intervals", "crossings", "point"}


@pytest.mark.nightly
@pytest.mark.parametrize("seeds", [range(k, k + 15) for k in range(0, 60, 15)], ids=str)
def test_random_diagrams_are_proved(seeds: range) -> None:
    """What they hold is compared with brute force in the folder of parameters."""
    proved = 0
    for seed in seeds:
        family = Draw(seed).family(light=True)
        map_ = family.map()
        orders = sorted({d for n in family.orders for d in range(1, n + 1) if n % d == 0})
        diagram = bifurcation_diagram(map_, "p", family.span, orders)
        if diagram.branches:
            found = prove(diagram, map_, orders=orders)
            proved += 1
            assert check(found.content) == found.statement
    assert proved >= 12


# --- What does not pass ---------------------------------------------------------------------------


def small() -> list[dict[str, Any]]:
    """Certificates of both kinds, with all that they can hold."""
    point = random_map(1)
    maps = [
        prove(P1L.at({"a": "5/4", "r": 1}), order=3),
        prove(PiecewiseLinearMap([("-x", "x <= 1"), ("x + 1", "x > 1")]), order=2),
        prove(certified.read(point), order=2),
    ]
    return [dict(each.content) for each in (*maps, fold_flip(), tent(), quotients())]


CERTIFICATES = small()
EACH = pytest.mark.parametrize("content", CERTIFICATES, ids=range(len(CERTIFICATES)))


@EACH
def test_no_tampered_file_passes(content: dict[str, Any], tmp_path: Path) -> None:
    """Any character changed, left out or doubled."""
    file = tmp_path / "certificate.json"
    for other in changed_texts(json.dumps(content), random.Random(7), 150):
        file.write_text(other, encoding="utf-8")
        with pytest.raises(Refused):
            check_certificate(file)


@pytest.mark.nightly
@EACH
def test_no_tampered_claim_passes_with_a_new_seal(content: dict[str, Any]) -> None:
    """Claims that are wrong are refused for themselves, not for the sentence or the seal."""
    rng = random.Random(11)
    claims = ("order", "orders", "edges", "fixed points", "intervals", "crossings", "points")
    places = [path for path in paths(content) if path[0] in claims]
    others = [
        (path, replaced(content, path, changed(at(content, path), rng)))
        for path in places * (1 + 200 // len(places))
    ] + [(path, without(content, path)) for path in places]
    wrong = [(path, other) for path, other in others if not says_the_same(content, other, path)]
    for path, other in wrong:
        sentence = refused(sealed(other))
        if path[0] != "edges":  # over a longer span the same can be true
            assert refused_claims(other) == sentence, path
    assert len(wrong) > 150


def says_the_same(content: dict[str, Any], other: dict[str, Any], path: certified.Path) -> bool:
    """Whether a change at a place is none, or writes the same number in another way."""
    if canonical(content) == canonical(other):
        return True
    for n, key in enumerate(path, start=1):
        one, new = at(content, path[:n]), at(other, path[:n]) if n < len(path) else None
        new = at(other, path[: n - 1]).get(key) if isinstance(key, str) else new
        if key == "places":
            return is_weaker(content, one, new)
        if key in ("x", "slope", "left", "right") and content["kind"] == "diagram":
            return same_number(one, new) if path[0] == "points" else same_quotient(one, new)
        if path[0] == "edges" and n == 2 == len(path[:n]):
            return same_number(one, new)
    return False


def is_weaker(content: dict[str, Any], one: list[int], new: Any) -> bool:
    """Whether a claim gives up just the first or the last edge, where others may exist."""
    last = 2 * len(content["edges"]) - 2
    ends = [one[0] or 1, one[1] - (one[1] == last)]
    return new in ([ends[0], one[1]], [one[0], ends[1]]) and new != one


def same_quotient(one: Any, other: Any) -> bool:
    """Whether two quotients of polynomials are equal."""
    try:
        (a, b), (c, d) = ([tuple(map(Fraction, part)) for part in each] for each in (one, other))
    except (TypeError, ValueError, ZeroDivisionError):
        return False
    return bool(d) and independent.product(a, d) == independent.product(c, b)


def same_number(one: Any, other: Any) -> bool:
    """Whether two numbers of a certificate are equal, to many digits."""
    try:
        return abs(approximated(one) - approximated(other)) < Fraction(1, 10**12)
    except (AssertionError, TypeError, ValueError, KeyError, ZeroDivisionError):
        return False


def approximated(number: Any) -> Fraction:
    if isinstance(number, str):
        return Fraction(number)
    poly, (low, high) = (list(map(Fraction, number[name])) for name in ("polynomial", "interval"))
    return rational_near(independent.Root(tuple(poly), low, high))


ODD = [None, True, -1, 0, 10**30, "", "x", "1e9", "1/0", "01", "-0", "²", "9" * 5000, "\ud800",
       [], {}, [[]], ["1", "2", "3"], {"x": 1}, 0.5, float("nan")]  # fmt: skip


@pytest.mark.nightly
@EACH
def test_whatever_stands_at_a_place_ends_in_a_sentence(content: dict[str, Any]) -> None:
    """The sentence names the seal only where the seal was changed; some changes change nothing."""
    rng, refusals = random.Random(3), 0
    for path in rng.choices(list(paths(content)), k=300):
        other = replaced(content, path, rng.choice(ODD))
        if not says_the_same(content, other, path):
            broken = path == ("seal",)
            sentence = refused(other if broken else sealed(other))
            assert (sentence == "the seal is not that of the content") is broken
            refusals += 1
    assert refusals > 280


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (b"", "this is no JSON"),
        (b"\xff\xfe", "this is no JSON"),
        (b"[]", "the seal is not that of the content"),
        (b'{"a": 1, "a": 1}', "a name occurs twice"),
        (b'{"a": 0.5}', "numbers of a certificate must be integers or text, got 0.5"),
        (b'{"a": NaN}', "numbers of a certificate must be integers or text, got NaN"),
        (b"[" * 100_000, "this is no JSON"),
        (b"9" * 10_000, "this is no JSON"),
        (b" " * 4_000_001, "a certificate of at most 4000000 bytes was expected"),
    ],
)
def test_what_is_no_certificate_is_refused(data: bytes, sentence: str, tmp_path: Path) -> None:
    file = tmp_path / "certificate.json"
    file.write_bytes(data)
    with pytest.raises(Refused, match=f"^{sentence}"):
        check_certificate(file)


def test_no_file_is_refused(tmp_path: Path) -> None:
    missing = "No such file or directory"
    for path, why in ((tmp_path, ".*"), (tmp_path / "nothing", missing), ("a\0b", ".*")):
        with pytest.raises(Refused, match=f"^cannot read the file: {why}$"):
            check_certificate(path)


@pytest.mark.nightly
def test_more_pieces_than_are_allowed_are_refused() -> None:
    """A saw of twenty teeth, each of which covers all of them, so that P_j has 20^j pieces."""
    n = 20
    letters = "ABCDEFGHIJKLMNOPQRST"
    pieces = {x: {"slope": str(n), "intercept": str(-n * i)} for i, x in enumerate(letters)}
    content = {
        "format": FORMAT, "version": 1, "kind": FIXED_POINTS, "statement": "",
        "map": {"variable": "x", "parameter": None, "slots": "".join(2 * x for x in letters)[:-1],
                "pieces": pieces, "breaks": [str(i) for i in range(1, n)], "denominator": "1"},
        "order": 30, "fixed points": [], "intervals": [], "crossings": [],
    }  # fmt: skip
    assert refused(sealed(content)).endswith("pieces, too many to be checked")


# --- What the prover refuses ----------------------------------------------------------------------


def test_what_cannot_be_certified_is_named() -> None:
    map_ = P1L.at({"a": "5/4"})
    diagram = bifurcation_diagram(map_, "r", (-1, 3), (1, 2))
    twice = map_.iterate(2)
    other = PiecewiseLinearMap.from_sympy("Piecewise((r - 2, x <= 0), (r - 2*x, True))")
    cases: list[tuple[tuple[Any, ...], dict[str, Any], str]] = [
        ((diagram, P1L), {}, r"must have the parameter r alone, it has \['a', 'r'\]"),
        ((diagram, map_), {"orders": [1, 3]}, r"must have the orders \[1, 3\], it has \[1, 2\]"),
        ((bifurcation_diagram(map_, "r", (-1, 3), (2,)), map_), {}, r"1, 2\], it has \[2\]"),
        ((diagram, other), {}, "x of R is another one for r between 0 and 2"),
        ((diagram.of_order(1), map_), {"orders": [1, 2]}, "P_2 has the crossings"),
        ((bifurcation_diagram(twice, "r", (-1, 3), (1,)), twice), {}, "the diagram of an iterate"),
    ]  # fmt: skip
    for arguments, options, sentence in cases:
        with pytest.raises(ValueError, match=sentence):
            prove(*arguments, **options)


def test_a_diagram_is_certified_with_the_divisors_of_its_orders() -> None:
    """x -> -x/2 for x < 0, p - x otherwise: for p < 0 nothing but 2-cycles is on the diagonal."""
    map_ = PiecewiseLinearMap.from_sympy("Piecewise((-x/2, x < 0), (p - x, True))")
    diagram = bifurcation_diagram(map_, "p", (-3, -1), orders=(1, 2))
    assert {branch.order for branch in diagram.branches} == {2}
    for orders in (None, (2,)):
        content = prove(diagram, map_, orders=orders).content
        assert content["orders"] == [1, 2]
        assert {row["order"] for row in content["fixed points"]} == {2}


def test_bands_beside_branches_do_not_change_the_certificate() -> None:
    """The tent map has four bands up to 2**(1/4), of a diagram of orders 1 and 2."""
    map_, span = TENT, ("9/8", "5/4")
    diagram = bifurcation_diagram(map_, "s", span, (1, 2))
    both = with_attractors(diagram, attractor_diagram(map_, "s", span, 1))
    assert 4 in {branch.order for branch in both.branches}
    assert prove(both, map_).content == prove(diagram, map_).content


def test_an_iterate_is_certified_as_one() -> None:
    map_ = P1L.at({"a": "5/4", "r": 1})
    assert prove(map_.iterate(2), order=2).content == prove(map_, order=4).content


# --- The checker by itself ------------------------------------------------------------------------


@pytest.mark.nightly
def test_the_checker_runs_without_any_installed_package(tmp_path: Path) -> None:
    """Its folder alone, beside an empty package, where no other package can be imported."""
    shutil.copytree(CHECKER, tmp_path / "pwmap" / "checking")
    (tmp_path / "pwmap" / "__init__.py").touch()
    found = tent()
    file = found.save(tmp_path / "certificate.json")
    code = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import pwmap.checking as c; "
        f"print(c.check_certificate({str(file)!r})); "
        "print(sorted(name for name in sys.modules if name.startswith(('sympy', 'numpy'))))"
    )
    done = subprocess.run(
        [sys.executable, "-I", "-S", "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"{found.statement}\n[]\n"


@pytest.mark.slow
def test_a_file_says_what_the_certificate_says(tmp_path: Path) -> None:
    assert [c["map"]["denominator"] for c in CERTIFICATES].count(["1"]) == 2
    for content in CERTIFICATES:
        found = Certificate(content)
        assert check_certificate(found.save(tmp_path / "c.json")) == found.statement
        assert json.loads((tmp_path / "c.json").read_text()) == content


def test_committed_certificates_pass() -> None:
    folder = Path(__file__).parents[3] / "studies" / "results" / "certificates"
    statements = [check_certificate(path) for path in sorted(folder.glob("*.json"))]
    assert len(statements) >= 7
    assert sum("FF, fold, at r = 0 and x = 0" in text for text in statements) == 1
    assert sum("the root of -1 - t + t^2" in text for text in statements) == 1
