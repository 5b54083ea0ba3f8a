"""What is too large is refused at once, and what is left out is said."""

import pytest
from effort import at_most

from pwmap import Budget, BudgetError, PiecewiseLinearMap, bifurcation_diagram, parameter_cells
from pwmap.diagrams.diagram import Diagram
from pwmap.diagrams.tables import LONGEST, short
from pwmap.maps import Meter, Progress
from pwmap.maps.cylinders import WHOLE_LINE, refined


def tent() -> PiecewiseLinearMap:
    return PiecewiseLinearMap([("m*x", "x <= 1/2"), ("m - m*x", "x > 1/2")])


@pytest.mark.parametrize(
    ("ask", "letters"),
    [
        (lambda: tent().iterate(10**9), 10**9),
        (lambda: tent().iterate(30).iterate(400), 12000),
        (lambda: bifurcation_diagram(tent(), "m", orders=(10**6,)), 10**6),
        (lambda: bifurcation_diagram(tent(), "m", orders=range(1, 10**9)), 10001),
        (lambda: bifurcation_diagram(tent().iterate(20), "m", orders=(1000,)), 20000),
        (lambda: parameter_cells(tent(), "m", orders=(10**6,)), 10**6),
    ],
)  # fmt: skip
def test_long_words_are_refused_at_once(ask: object, letters: int) -> None:
    refused = pytest.raises(BudgetError, match=f"a word of {letters} letters, at most 10000")
    with at_most(300_000), refused:
        ask()  # type: ignore[operator]


def test_the_longest_word_is_allowed() -> None:
    assert tent().iterate(10000).order == 10000


def seen(diagram: Diagram) -> list[tuple[object, ...]]:
    return [(b.word, b.ends, b.exact) for b in diagram.branches]


@pytest.mark.nightly
def test_a_diagram_stops_after_the_orders_that_the_budget_allows() -> None:
    told: list[Progress] = []
    budget = Budget(pieces=600)
    whole = bifurcation_diagram(tent(), "m", (0, 2), range(1, 6))
    cut = bifurcation_diagram(tent(), "m", (0, 2), range(1, 9), budget=budget, progress=told.append)
    assert seen(cut) == seen(whole)
    assert whole.given == ()
    assert cut.given == (
        "stopped after orders 1..5: order 6 takes more than 600 pieces in all cells",
    )
    assert cut.graph().graph["given"] == cut.given[0]
    assert told == [
        Progress(1, 5, 12), Progress(2, 5, 26), Progress(3, 7, 64), Progress(4, 9, 163),
        Progress(5, 15, 517),
    ]  # fmt: skip
    some = bifurcation_diagram(tent(), "m", (0, 2), (2, 5, 8), budget=budget)
    assert some.given[0].startswith("stopped after orders 2, 5: order 6 takes more than 600 pieces")


def test_the_budget_itself_is_allowed() -> None:
    exact = bifurcation_diagram(tent(), "m", (0, 2), range(1, 6), budget=Budget(pieces=517))
    assert exact.given == ()


def test_no_order_completed_is_an_error() -> None:
    with pytest.raises(BudgetError, match="order 6 takes more than 600 pieces in all cells"):
        bifurcation_diagram(tent(), "m", (0, 2), (7,), budget=Budget(pieces=600))


def test_an_iterate_of_too_many_pieces_says_how_many() -> None:
    map_ = tent().at({"m": 2})
    pieces = WHOLE_LINE
    budget = Budget(pieces=20)
    for _ in range(4):
        pieces = refined(pieces, 0, map_.oracle, Meter(budget), map_.oracle.ask)
    sentence = "words of 5 letters has more than 20 pieces; one letter less makes 16"
    with pytest.raises(BudgetError, match=sentence):
        refined(pieces, 0, map_.oracle, Meter(budget), map_.oracle.ask)


def test_an_interrupt_keeps_what_was_completed_if_that_is_wanted() -> None:
    def progress(done: Progress) -> None:
        if done.order == 3:
            raise KeyboardInterrupt

    calls: list[int] = []
    cut = bifurcation_diagram(
        tent(), "m", (0, 2), range(1, 7), progress=progress, on_interrupt=lambda: calls.append(1)
    )
    assert seen(cut) == seen(bifurcation_diagram(tent(), "m", (0, 2), (1, 2, 3)))
    assert (cut.given, calls) == (("stopped after orders 1..3: interrupted",), [1])
    with pytest.raises(KeyboardInterrupt):
        bifurcation_diagram(tent(), "m", (0, 2), range(1, 7), progress=progress)


def test_long_texts_keep_their_beginning_and_their_end() -> None:
    assert short("a" * LONGEST) == "a" * LONGEST
    text = short("(" + "x + " * 100 + "1)")
    assert len(text) == LONGEST
    assert text.startswith("(x + x + ")
    assert text.endswith(" + 1)")
    assert "(403 characters)" in text
