"""Forged certificates: true ones with claims that are wrong are refused for these claims."""

import copy
import os
from fractions import Fraction
from pathlib import Path
from typing import Any

import certified
import pytest
from certified import refused_claims, sealed
from typer.testing import CliRunner

from pwmap import PiecewiseLinearMap, bifurcation_diagram, check_certificate, prove
from pwmap.checking import polynomials
from pwmap.checking.__main__ import main
from pwmap.checking.certificate import statement_of
from pwmap.checking.polynomials import between
from pwmap.checking.reading import number
from pwmap.checking.refusing import Effort
from pwmap.cli.app import app
from pwmap.proofs import Refused

Content = dict[str, Any]


def proved(text: str, parameter: str, span: tuple[Any, Any], orders: tuple[int, ...]) -> Content:
    """A copy of what is proved of a diagram."""
    map_ = PiecewiseLinearMap.from_sympy(text)
    found = prove(bifurcation_diagram(map_, parameter, span, orders), map_, orders=orders)
    return copy.deepcopy(dict(found.content))


def refused(content: Content) -> str:
    """The sentence with which claims are refused; with a new seal they are, too."""
    certified.refused(sealed(content))
    sentence = refused_claims(content)
    assert len(sentence) < 1500
    return sentence


# --- Numbers --------------------------------------------------------------------------------------

HALF = {"polynomial": ["-1", "2"], "interval": ["0", "1"]}
TWO = {"polynomial": ["-2", "1"], "interval": ["1", "3"]}


@pytest.mark.parametrize("edges", [[HALF, "1"], ["1", TWO]], ids=["high", "low"])
def test_what_holds_at_an_edge_is_not_taken_for_what_holds_beside_it(edges: list[Any]) -> None:
    """All points are fixed by x -> p x at p = 1 alone; p = 1 is an end of the other's interval."""
    content = proved("Piecewise((p*x, True))", "p", ("1/2", 2), (1,))
    assert content["intervals"] == [{"order": 1, "word": "A", "places": [2, 2]}]
    forged = content | {
        "edges": edges, "fixed points": [], "points": [],
        "intervals": [{"order": 1, "word": "A", "places": [1, 1]}],
    }  # fmt: skip
    assert refused(forged).startswith("edges must ascend, with intervals that part them, got ")


def test_two_roots_may_share_the_end_of_their_intervals() -> None:
    low, high = (
        number({**HALF, "interval": ends}, Effort()) for ends in (["0", "1"], ["1/3", "1"])
    )
    two = number(TWO, Effort())
    assert between(low, two) == 1
    one = number("1", Effort())
    for pair in ((one, one), (low, one), (one, two), (low, low), (low, high), (two, low)):
        with pytest.raises(Refused, match="edges must ascend"):
            between(*pair)
    assert between(low, number("2", Effort())) == Fraction(3, 2)


@pytest.mark.parametrize("polynomial", [["1", "-4", "4"], ["1", "-8", "24", "-32", "16"]])
def test_a_polynomial_that_keeps_its_sign_gives_no_number(polynomial: list[str]) -> None:
    """Else x = 1/2, a root of (1 - 2 x)^2, would be taken for another number than 1/2."""
    value = {"polynomial": polynomial, "interval": ["-1", "1"]}
    with pytest.raises(Refused, match="does not change its sign at just one root between -1 and 1"):
        number(value, Effort())
    content = proved("Piecewise((r - 2, x <= 0), (r - 5*x/4, True))", "r", (-1, 3), (1, 2))
    forged = copy.deepcopy(content)
    forged["points"][0]["x"] = {"polynomial": ["0", "0", "1"], "interval": ["-1", "1"]}
    assert "does not change its sign at just one root" in refused(forged)
    forged["points"][0]["x"] = {"polynomial": ["0", "0", "0", "1"], "interval": ["-1", "1"]}
    assert "FF, fold, at r = 0 and x = the root of t^3" in statement_of(forged)


def test_work_is_counted_before_it_is_done() -> None:
    """Of each edge whose polynomial is read, too; common denominators have a bound."""
    row = {"polynomial": ["-7", *["3"] * 198, "2"], "interval": ["0", "2"]}
    work = Effort(10**6)
    with pytest.raises(Refused, match="more work than a check may"):
        number(row, work)
    content = proved("Piecewise((r - 2, x <= 0), (r - 5*x/4, True))", "r", (-1, 3), (1, 2))
    primes = [str(10**150 + n) for n in range(60)]
    content["fixed points"][0]["x"] = [[f"1/{n}" for n in primes], ["1"]]
    assert refused(content) == "the common denominator of some numbers is too large"


# --- Stretches, and what ends where ---------------------------------------------------------------


def paper() -> Content:
    """The paper's map, with one more edge, at which nothing changes."""
    content = proved("Piecewise((r - 2, x <= 0), (r - 5*x/4, True))", "r", (-1, 3), (1, 2))
    content["edges"].insert(3, "5/2")
    for row in content["fixed points"] + content["crossings"]:
        row["places"] = [place + 2 * (place == 6) for place in row["places"]]
    assert "inside, single fixed points begin and end only at 2 special points" in statement_of(
        content
    )
    return content


INVENTED: Content = {
    "edge": 3, "x": "10/9", "code": "BC", "note": "", "signs": None,
    "conditions": [{"word": "R", "side": side, "vanishing": [], "simple": []} for side in (-1, 1)],
}  # fmt: skip


def cut(rows: list[Content], word: str, *places: list[int]) -> None:
    """Cut the stretch of a word into several."""
    (row,) = (row for row in rows if row["word"] == word)
    i = rows.index(row)
    rows[i : i + 1] = [row | {"places": each} for each in places]


@pytest.mark.nightly
@pytest.mark.parametrize("is_listed", [True, False])
def test_a_stretch_cannot_be_cut_to_make_a_special_point(is_listed: bool) -> None:
    sentences = {
        ((3, 5), (6, 8)): "two stretches of R must be one, nothing changes at r = 5/2",
        ((3, 6), (7, 8)): "two stretches of R must be one, nothing changes for r between 5/2 and 3",
        ((3, 6), (6, 8)): "two stretches of R overlap at r = 5/2",
        ((3, 8), (6, 6)): "two stretches of R overlap at r = 5/2",
    }
    for places, sentence in sentences.items():
        content = paper()
        content["points"] += [INVENTED] * is_listed
        cut(content["fixed points"], "R", *map(list, places))
        assert refused(content) == sentence


@pytest.mark.slow
def test_fixed_points_that_pass_make_no_special_point() -> None:
    content = paper()
    content["points"].append(INVENTED)
    sentence = "no fixed points end at r = {} and x = {}, or they are listed twice"
    assert refused(content) == sentence.format("5/2", "10/9")
    content = proved("Piecewise((x/2, x <= 0), (r*x, True))", "r", ("1/4", "1/2"), (1,))
    content["edges"].insert(1, "1/3")
    (row,) = content["fixed points"]  # x = 0, which stays on the border
    row["places"] = [0, 4]
    assert statement_of(content).endswith("begin and end nowhere.")
    point = copy.deepcopy(INVENTED) | {"edge": 1, "x": "0"}
    for condition in point["conditions"]:
        condition["word"] = "L"
    content["points"] = [point]
    assert refused(content) == sentence.format("1/3", "0")


@pytest.mark.slow
def test_jumps_and_intervals_cannot_be_cut() -> None:
    content = paper()
    cut(content["crossings"], "RR|RL", [3, 6], [7, 8])
    assert (
        refused(content)
        == "two stretches of RR|RL must be one, nothing changes for r between 5/2 and 3"
    )
    content = proved("Piecewise((x, x <= 0), (r + 2, True))", "r", (-3, 3), (1,))
    (row,) = content["intervals"]
    first, last = row["places"]
    assert last - first >= 2
    cut(content["intervals"], row["word"], [first, first], [first + 1, last])
    assert refused(content).startswith(
        f"two stretches of {row['word']} must be one, nothing changes "
    )


JUMPS = "Piecewise((7, x < 0), (r + 2, x <= 0), (-1, x <= 2), (0, x <= 4), (-9, True))"


def test_a_jump_that_passes_is_no_end_and_keeps_the_kind_of_a_point() -> None:
    """At r = 0 and x = 2 a fixed point of P_2 passes from one side of the jump to the other."""
    content = proved(JUMPS, "r", (-1, 1), (1, 2))
    kinds = [(p["x"], p["code"], p["note"]) for p in content["points"]]
    assert kinds == [("0", "BC", "fold"), ("2", "BC", "persistence")]
    sentence = "two stretches of {} must be one, nothing changes for r between 0 and 1"
    passing = [row for row in content["crossings"] if row["places"][0] < 2 < row["places"][1]]
    assert passing
    for row in passing:
        first, last = row["places"]
        forged = copy.deepcopy(content)
        cut(forged["crossings"], row["word"], [first, 2], [3, last])
        assert refused(forged) == sentence.format(row["word"])


def test_stability_holds_at_the_ends_of_stretches() -> None:
    """At r = 2 the fixed point 0 of the paper's map attracts on one side only."""
    content = paper()
    rows = [r for r in content["fixed points"] if r["word"] == "L"]
    assert [(r["places"], r["stable"]) for r in rows] == [([0, 3], True), ([4, 4], False)]
    forged = copy.deepcopy(content)
    forged["fixed points"] = [r for r in forged["fixed points"] if r["places"] != [4, 4]]
    forged["fixed points"][0]["places"] = [0, 4]
    assert refused(forged) == "L is not attracting at r = 2"
    forged = copy.deepcopy(content)
    forged["fixed points"][1]["stable"] = True
    assert refused(forged) == "two stretches of L must be one, nothing changes at r = 2"


def test_the_slope_holds_at_the_ends_of_stretches() -> None:
    """The points that visit A and then B are those of [-r, 0], at r = 0 this one alone."""
    content = proved(
        "Piecewise((x + 1 + r, x <= 0), (5, x < 1), ((1 - x)/2, True))", "r", (-1, "1/2"), (1, 2)
    )
    edge = content["edges"].index("0")
    rows = [r for r in content["fixed points"] if r["word"] == "LR"]
    assert [(r["places"][0], r["slope"], r["stable"]) for r in rows] == [
        (2 * edge, None, False),
        (2 * edge + 1, [["-1"], ["2"]], True),
    ]
    forged = copy.deepcopy(content)
    for row in forged["fixed points"]:
        if row["word"] == "LR":
            row["slope"] = rows[1]["slope"]
    assert refused(forged) == "slope of LR is another one at r = 0"


@pytest.mark.parametrize(
    ("text", "span", "intervals"),
    [
        ("Piecewise((x + 2, x <= 0), (10, x <= 3 - r), (x - 2, True))", ("1/2", 2),
         [(2, "LR", [3, 3]), (2, "RL", [3, 3])]),
        ("Piecewise((x + r, x <= 0), (x - r, True))", (-1, 1),
         [(1, "L", [2, 2]), (1, "R", [2, 2]), (2, "LR", [3, 3]), (2, "RL", [3, 3])]),
    ],
)  # fmt: skip
def test_where_intervals_begin_is_told_by_their_stretches(
    text: str, span: tuple[Any, Any], intervals: list[Any]
) -> None:
    """The sentence on what begins and ends is one on single fixed points."""
    map_ = PiecewiseLinearMap.from_sympy(text, given=["r < 3", "r > -3"])
    found = prove(bifurcation_diagram(map_, "r", span, (1, 2)), map_)
    rows = found.content["intervals"]
    assert [(r["order"], r["word"], r["places"]) for r in rows] == intervals
    assert found.statement.endswith("; inside, single fixed points begin and end nowhere.")


# --- Sizes, files and commands --------------------------------------------------------------------

LONG = "7" + "3" * 398


def test_numbers_with_too_many_digits_are_refused() -> None:
    """Python writes no integers of more than 4300 digits."""
    map_ = PiecewiseLinearMap.from_sympy(f"Piecewise(({LONG}*x + 1, True))")
    content = dict(prove(map_).content)
    assert refused(content | {"order": 12}) == "a number has too many digits to be written"
    with pytest.raises(Refused, match="a number has too many digits"):
        polynomials.text((1, -(10**5000)), "p")


def test_sentences_show_the_beginning_of_long_numbers() -> None:
    """Edges, the polynomials that isolate them, and points."""
    content = proved("Piecewise((r - 2, x <= 0), (r - 5*x/4, True))", "r", (-1, 3), (1, 2))
    edge = {"polynomial": [LONG, *[LONG] * 3, "-" + LONG], "interval": ["0", LONG]}
    assert len(refused(content | {"edges": [edge, "0"]})) < 400
    assert len(refused(content | {"edges": ["-1", edge, "3"], "points": []})) < 600
    edge["polynomial"][0] = "-" + LONG
    assert len(refused(content | {"edges": [edge, "0"]})) < 400


def test_only_regular_files_are_read(tmp_path: Path) -> None:
    """A pipe would keep the checker waiting."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(Refused, match="is no regular file"):
        check_certificate(pipe)


@pytest.mark.parametrize("path", [None, 5, b"certificate.json"])
def test_what_is_no_path_is_named(path: Any) -> None:
    with pytest.raises(Refused, match=f"^the path of a file was expected, got {path!r}$"):
        check_certificate(path)


@pytest.fixture
def files(tmp_path: Path) -> list[str]:
    """A file that is refused, one that passes, and none."""
    found = prove(PiecewiseLinearMap.from_sympy("Piecewise((x/2, True))"))
    (tmp_path / "bad.json").write_text("{}")
    found.save(tmp_path / "good.json")
    return [str(tmp_path / name) for name in ("bad.json", "good.json", "none.json")]


def test_the_command_names_each_file_and_goes_on(files: list[str]) -> None:
    done = CliRunner().invoke(app, ["check", *files])
    assert done.exit_code == 1
    assert done.stdout.startswith(
        f"{files[1]}: For the map with the pieces A: 1/2 x for all x, all"
    )
    assert f"{files[0]} is refused: the seal is not that of the content" in done.stderr
    assert f"{files[2]} is refused: cannot read the file" in done.stderr
    assert CliRunner().invoke(app, ["check", files[1]]).exit_code == 0


def test_the_program_names_each_file_and_goes_on(
    files: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(files) == 1
    shown = capsys.readouterr()
    assert shown.out.startswith(f"{files[1]}: For the map with the pieces A: 1/2 x for all x")
    refusals = [line.partition(" is refused: ")[0] for line in shown.err.splitlines()]
    assert refusals == [files[0], files[2]]
    assert main(files[1:2]) == 0
    assert main([]) == 2
    assert capsys.readouterr().err == "usage: python -m pwmap.checking certificate.json ...\n"
