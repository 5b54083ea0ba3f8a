"""Certificates of branches, points and cycles that say more than is so, sealed anew: refused."""

import copy
import json
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("flint")

from needs import SLOW_TOY
from tampering import moved, resealed

from pwmap.checking import Refused
from woodpecker import Toy, prove, shoot
from woodpecker.checking import pieces
from woodpecker.checking.certificate import check
from woodpecker.checking.intervals import I, unit
from woodpecker.checking.pieces import claimed
from woodpecker.enclosures.forms import precision
from woodpecker.enclosures.model import rational
from woodpecker.proofs import NotProved, certificates
from woodpecker.proofs.branches import PieceEnd, joined
from woodpecker.proofs.pieces import Fractions, Route, Tube, proved, value_of
from woodpecker.proofs.proving import sealed
from woodpecker.proofs.statements import parts_of

KEPT = Path(__file__).parents[3] / "studies" / "results" / "proofs"
Content = dict[str, Any]
PIECES = (773, 776)  # of the kept branch: one, the flip, one more


def kept(name: str) -> Content:
    content = json.loads((KEPT / f"{name}.json").read_text(encoding="ascii"))
    return {key: value for key, value in content.items() if key not in ("seal", "statement")}


def signed(content: Content) -> Content:
    """With the sentence and the seal that it would have."""
    return dict(sealed(content).content)


def end_of(piece: Content, side: int) -> str:
    line = [Fraction(c) for c in piece["line"]]
    return certificates.text(value_of(line, side * Fraction(piece["half"])))


@pytest.fixture(scope="module")
def branch() -> Content:
    """The part of the kept branch about its flip."""
    content, (first, last) = kept("branch"), PIECES
    for key in ("pieces", "multiplier", "stable"):
        content[key] = content[key][first:last]
    content["flips"] = [k - first for k in content["flips"] if first <= k < last]
    content["span"] = [end_of(content["pieces"][0], -1), end_of(content["pieces"][-1], 1)]
    return content


def flips(value: list[Any]) -> Callable[[Content], None]:
    return lambda c: c.update(flips=value)


def drop_a_piece(c: Content) -> None:
    for key in ("pieces", "multiplier", "stable"):
        del c[key][1]
    c["flips"] = [k - 1 for k in c["flips"]]


def drop_the_flip(c: Content) -> None:
    k = c["flips"].pop()
    low, high = (end_of(c["pieces"][k], side) for side in (-1, 1))
    for key in ("pieces", "multiplier", "stable"):
        del c[key][k]
    c["flips"], c["gaps"] = [k], [[low, high]]  # and yet one claims to know of a flip


def invent_a_gap(c: Content) -> None:
    c["gaps"] = [["0.3", "0.31"]]


def longer_span(c: Content) -> None:
    c["span"][1] = moved(c["span"][1], Fraction(1, 1000))


def other_stability(c: Content) -> None:
    c["stable"][0] = not c["stable"][0]


def thinner_tube(c: Content) -> None:
    point = c["pieces"][0]["points"][0]
    point["radius"] = certificates.text(Fraction(point["radius"]) / 10**12)


def shifted_tube(c: Content) -> None:
    point = c["pieces"][0]["points"][0]
    point["curve"][0] = moved(point["curve"][0], 10 * Fraction(point["radius"]))


def no_pieces(c: Content) -> None:
    c |= {"pieces": [], "multiplier": [], "stable": [], "flips": []}


@pytest.mark.slow
def test_the_part_about_the_flip_is_true(branch: Content) -> None:
    content = signed(branch)
    assert check(content) == content["statement"]
    assert "with exactly one flip" in content["statement"]


@pytest.mark.nightly
@pytest.mark.parametrize("change", [thinner_tube, shifted_tube])
def test_false_tubes_are_refused(branch: Content, change: Callable[[Content], None]) -> None:
    content = copy.deepcopy(branch)
    change(content)
    assert json.dumps(content) != json.dumps(branch)
    with pytest.raises(Refused):
        check(signed(content))


def other_statement(c: Content) -> None:
    c["statement"] = c["statement"].replace("exactly one flip", "no flip")


def odd_event(c: Content) -> None:
    c["pieces"][-1]["points"][0]["ways"][0]["events"][-1][0] = "gap 4"


def odd_number(c: Content) -> None:
    c["pieces"][-1]["points"][0]["curve"][-1] = "1e9"


CLAIMS = [
    *map(flips, ([1, 1], [-1, 1], [1, 99], [10**6], [True], [1.0], ["1"], [], [0], [1, 2])),
    drop_a_piece, drop_the_flip, invent_a_gap, longer_span, other_stability, no_pieces, odd_event,
    odd_number,
]  # fmt: skip


@pytest.mark.parametrize("change", CLAIMS)
def test_claims_that_contradict_each_other_are_refused_before_any_motion_is_followed(
    branch: Content, change: Callable[[Content], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A whole branch takes minutes."""
    followed = list[Any]()
    monkeypatch.setattr(pieces, "run", lambda *way: followed.append(way))
    content = copy.deepcopy(branch)
    change(content)
    with pytest.raises(Refused):
        check(signed(content))
    assert not followed
    said = signed(branch)
    other_statement(said)
    with pytest.raises(Refused, match="the statement is another one than the claims make"):
        check(resealed(said))
    assert not followed


OTHER = {0: 1, 1: 0, "FF": "BC", "BC": "FF", "fold": "persistence", "persistence": "fold"}


def swap(*keys: str) -> Callable[[Content], None]:
    """The other value of a choice, the other order of two sides."""

    def change(c: Content) -> None:
        for key in keys:
            match key:
                case "side":
                    c["side"] = -c["side"]
                case "own" | "code" | "note":
                    c[key] = OTHER[c[key]]
                case _:
                    c[key] = c[key][::-1]

    return change


def shift(key: str, by: Fraction, *inner: int | str) -> Callable[[Content], None]:
    def change(c: Content) -> None:
        pair, at = c, [key, *inner]
        for part in at[:-1]:
            pair = pair[part]
        old = pair[at[-1]]
        pair[at[-1]] = [moved(x, by) for x in old] if isinstance(old, list) else moved(old, by)

    return change


TINY, SMALL = Fraction(1, 10**24), Fraction(1, 10**16)  # more than the widths of claims
POINTS = [
    swap("own"), swap("side"), swap("code"), swap("note"), swap("ways"), swap("slopes"),
    swap("own", "side"), swap("ways", "slopes"), swap("code", "note"), swap("own", "ways"),
    shift("x", TINY), shift("p", TINY), shift("limit", TINY), shift("slopes", SMALL, 0),
    shift("slopes", SMALL, 1), shift("centre", TINY, "x"), shift("centre", TINY, "p"),
    shift("toy", TINY, "l_s"),
]  # fmt: skip


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["A", "C"])
@pytest.mark.parametrize("change", POINTS)
def test_false_points_are_refused(name: str, change: Callable[[Content], None]) -> None:
    content = kept(name)
    change(content)
    with pytest.raises(Refused):
        check(signed(content))


def test_a_fixed_point_is_no_cycle_of_two() -> None:
    """In the checker, and in the prover."""
    content = kept("cycle")
    content["order"] = 2
    for part in ("outer", "inner"):
        content[part]["points"] = 2 * content[part]["points"]
    content["multiplier"] = ["0.7041", "0.7042"]  # the square
    content["stable"] = True
    for key in ("period", "drop"):
        content[key] = [certificates.text(2 * Fraction(x)) for x in content[key]]
    with pytest.raises(Refused, match="the cycle may be one of 1, passed several times"):
        check(signed(content))
    toy = Toy(eps_n1=0.5)
    tube = Tube((rational(-0.529471967110851),), Fraction(1, 10**8))
    with (
        precision(140),
        pytest.raises(NotProved, match="the cycle may be one of 1, passed several times"),
    ):
        proved(toy, "eps_n1", Route((Fraction(1, 2),), Fraction(0)), [tube, tube])


def test_a_return_takes_time() -> None:
    """The start lies on the section: to be there is no return."""
    content = kept("cycle")
    now = [["section", "-0.00000000000000000001", "0.00000000000000000001"]]
    for part in ("outer", "inner"):
        content[part]["points"][0]["ways"] = [{"word": "", "events": now}]
    with pytest.raises(Refused, match="a phase has no duration"):
        check(signed(content))


@pytest.mark.slow
def test_what_is_proved_of_one_toy_is_not_said_of_the_papers() -> None:
    toy = Toy(eps_n1=0.5, g=9.7, mu_1=0.2)
    found = prove(shoot(toy, -0.53))
    assert check(dict(found.content)) == found.statement
    head = "The Woodpecker Toy (expansion friction summed; g = 9.7; mu_1 = 0.2) with eps_n1"
    assert found.statement.startswith(head)


@pytest.mark.slow
def test_the_only_cycle_is_so_about_the_places_that_are_named() -> None:
    content = kept("cycle")
    point = content["outer"]["points"][0]
    point["curve"][0] = moved(point["curve"][0], Fraction(1, 10**9))
    with pytest.raises(Refused, match="the middle of the outer one"):
        check(signed(content))


def test_claims_are_compared_exactly() -> None:
    """One that is narrower than what is found by less than a unit of the checker is refused."""
    low, high, less = Fraction(5, 2**20), Fraction(9, 2**20), Fraction(1, 2**22)
    with unit(20):
        claimed("it", I(5, 9), [str(low), str(high)])
        for ends in ([str(low + less), str(high)], [str(low), str(high - less)]):
            with pytest.raises(Refused, match="it could not be shown to lie in"):
                claimed("it", I(5, 9), ends)


ODD = [
    ["gap 3", "0.01"], "gap 3 0.01 0.02", ["gap 3", "0.01", "0.02", "0.03"], [3, "0.01", "0.02"],
    ["gap 3", "0.01", "1" * 2000], ["slip 2", "0.01", "100000"], ["gap 3", "-1000000000", "1"],
    ["gap 3", "0.02", "0.01"], ["gap 3", "\u0660.01", "0.02"], None, {},
]  # fmt: skip


@pytest.mark.parametrize("event", ODD)
@pytest.mark.parametrize("place", [0, 3, 8])
def test_odd_events_are_refused_with_a_sentence(event: Any, place: int) -> None:
    content = kept("cycle")
    content["outer"]["points"][0]["ways"][0]["events"][place] = event
    with pytest.raises(Refused, match=r"^[a-z][ -~]{10,250}$"):
        check(signed(content))


def test_a_parameter_that_does_not_move_is_refused_with_a_sentence(branch: Content) -> None:
    line = [branch["pieces"][0]["line"][0]]
    still = {"pieces": [{**branch["pieces"][0], "line": line}], "flips": [], "span": 2 * line}
    first = {key: branch[key][:1] for key in ("multiplier", "stable")}
    with pytest.raises(Refused, match="the parameter may turn round"):
        check(signed({**branch, **still, **first}))


def test_deep_and_huge_content_is_refused() -> None:
    deep: Any = []
    for _ in range(990):
        deep = [deep]
    for odd in (deep, 10**5000, {"a": deep}):
        with pytest.raises(Refused):
            check({**kept("cycle"), "more": odd})


@pytest.mark.nightly
def test_stretches_between_gaps_are_not_said_to_belong_together(branch: Content) -> None:
    content = copy.deepcopy(branch)
    drop_the_flip(content)
    content["flips"] = []
    ((low, high),) = content["gaps"]
    length = Fraction(high) - Fraction(low)
    said = check(signed(content))
    assert "2 stretches of tubes that join, and between them 1 interval, of a total length" in said
    told = Fraction(said.split("at most ")[1].split(",")[0])
    assert length <= told <= length * Fraction(11, 10)  # two digits, rounded up
    point = {**content["pieces"][0], "half": "0"}
    with pytest.raises(Refused, match="a piece of a branch has a length"):
        check(signed({**content, "pieces": [point, content["pieces"][1]]}))


@SLOW_TOY
def test_a_cycle_whose_word_is_open_is_told_both() -> None:
    """Where the lower sleeve only just stays, in a tube that holds starts of both words."""
    toy = Toy(eps_n1=0.20535840734706282)
    x = rational(shoot(toy, -0.7).phi_s)
    with precision(140):
        line = Route((rational(toy.eps_n1),), Fraction(0))
        piece = proved(toy, "eps_n1", line, [Tube((x,), Fraction(1, 10**6))])
        content = signed(certificates.of_orbit(toy, "eps_n1", piece, piece, 40))
    both = "Its word is S2 D2 I3 D3 I1 I3 D3 I2 J2 or S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2, "
    assert both in check(content)
    one = content["statement"].replace(" or S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2", "")
    with pytest.raises(Refused, match="the statement is another one"):
        check(resealed({**content, "statement": one}))


def test_parts_join_where_the_cycle_of_one_lies_in_the_tube_of_the_other() -> None:
    p, wide = Fraction(1, 2), Fractions(Fraction(-1), Fraction(1))

    def end(low: Fraction, high: Fraction, tube: Fractions = wide, at: Fraction = p) -> PieceEnd:
        return PieceEnd(at, (tube,), (Fractions(low, high),))

    inside, beside = end(Fraction(0), Fraction(1, 2)), end(Fraction(2), Fraction(3))
    narrow = end(Fraction(2), Fraction(3), Fractions(Fraction(2), Fraction(3)))
    assert joined(inside, inside)
    assert joined(beside, inside)  # what the second found lies in the tube of the first
    assert not joined(beside, beside)
    assert not joined(narrow, end(Fraction(0), Fraction(1), Fractions(Fraction(0), Fraction(1))))
    assert not joined(inside, inside._replace(p=Fraction(1, 3)))


@pytest.mark.parametrize("workers", [1, 2, 3, 7])
def test_parts_of_a_span_are_equal_however_short(workers: int) -> None:
    span = Fractions(Fraction("0.5"), Fraction("0.5000004"))
    parts = parts_of(span, workers)
    assert (parts[0].low, parts[-1].high, len(parts)) == (span.low, span.high, workers)
    assert {part.length for part in parts} == {span.length / workers}
    assert all(a.high == b.low for a, b in pairwise(parts))
