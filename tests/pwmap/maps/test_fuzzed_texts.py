"""Random texts are maps, assumptions and values, or are refused soon and in one sentence.

Most are made by the grammar of formulas, with what it lacks mixed in; the others are mutated, or
just any characters.
"""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given
from hypothesis import strategies as st
from test_reading import ATTACKS
from thoroughness import thorough

from pwmap import PiecewiseLinearMap, parameter_cells

SECONDS = 2.0  # of the processor, for one text

NUMBERS = st.integers(0, 12).map(str) | st.sampled_from(
    ["1/2", "-1", "64", "9" * 400, "9" * 1100, "0.1", "1e9999", "007", "9**9**9", "7**7**8"]
)
NAMES = st.sampled_from(["x", "x", "x", "a", "b", "r", "µ", "lambda", "nan", "pi", "sqrt", "True"])


def _joined(parts: st.SearchStrategy[str], *signs: str) -> st.SearchStrategy[str]:
    return st.tuples(parts, st.sampled_from(signs), parts).map(" ".join)


def _called(names: list[str], arguments: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    listed = st.lists(arguments, min_size=1, max_size=3).map(", ".join)
    return st.tuples(st.sampled_from(names), listed).map(lambda t: f"{t[0]}({t[1]})")


def _conditions(formulas: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    simple = _joined(st.just("x") | formulas, "<", "<=", ">", ">=")
    chains = _joined(simple, "<", "<=")
    both = st.tuples(simple, st.sampled_from(["&", "|", "and", "or"]), simple)
    return st.one_of(
        simple,
        chains,
        both.map(lambda t: f"({t[0]}) {t[1]} ({t[2]})"),
        _called(["And", "Or", "Not", "Eq", "Ne", "Gt"], simple | formulas),
        simple.map(lambda c: f"~({c})"),
    )


def _larger(formulas: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    pairs = st.tuples(formulas, _conditions(formulas)).map(lambda t: f"({t[0]}, {t[1]})")
    return st.one_of(
        _joined(formulas, "+", "-", "*", "/"),
        st.tuples(formulas, st.sampled_from(["2", "-1", "64", "2**3", "x"])).map(
            lambda t: f"({t[0]})**{t[1]}"
        ),
        _called(["Abs", "Max", "Min", "Rational", "f"], formulas),
        st.lists(pairs, min_size=1, max_size=3).map(
            lambda found: f"Piecewise({', '.join(found)}, (x, True))"
        ),
    )


FORMULAS = st.recursive(NAMES | NUMBERS, _larger, max_leaves=12)
WRITTEN = FORMULAS | _conditions(FORMULAS)


@st.composite
def mutated(draw: st.DrawFn) -> str:
    text = draw(WRITTEN)
    for _ in range(draw(st.integers(1, 3))):
        start = draw(st.integers(0, len(text)))
        stop = draw(st.integers(start, min(len(text), start + 4)))
        other = draw(
            st.sampled_from(["", *"[]{}.'\"\\;:=!@%^`\0\n", *ATTACKS]) | st.text(max_size=3)
        )
        text = text[:start] + other + text[stop:]
    return text


LONG = st.tuples(
    st.sampled_from(["(", "Abs(", "-", "~", "x*(", "9**", "a<", "Piecewise((1, x<0), (", "x+a*"]),
    st.sampled_from([10, 100, 1000]),
).map(lambda t: t[0] * t[1] + "x" + ")" * (t[0].count("(") * t[1]))
TEXTS = st.one_of(
    WRITTEN,
    mutated(),
    LONG,
    st.text(max_size=40),
    st.binary(max_size=40).map(lambda b: b.decode("latin1")),
)


@contextmanager
def _soon() -> Iterator[None]:
    """Fail if something takes too long; other processes do not count."""

    def stop(*_: object) -> None:
        raise TimeoutError(f"more than {SECONDS} s")

    if not hasattr(signal, "setitimer"):  # Windows
        yield
        return
    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


MAP = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
HALF = MAP.at({"a": 2})
WHOLE = HALF.at({"r": 1})
USES: dict[str, Callable[[str], Any]] = {
    "map": PiecewiseLinearMap.from_sympy,
    "pieces": lambda t: PiecewiseLinearMap([(t, t), ("1", f"~({t})")]),
    "assumption": lambda t: PiecewiseLinearMap.from_sympy("a*x + b", given=[t]),
    "value": lambda t: MAP.at({"a": t}),
    "point": lambda t: (WHOLE(t), MAP(t)),
    "name": lambda t: PiecewiseLinearMap.from_sympy("2*x", t),
    "span": lambda t: parameter_cells(HALF, "r", span=(t, f"{t} + 1")),
}


@pytest.mark.nightly
@pytest.mark.parametrize("use", USES)
def test_any_text_is_read_or_refused(use: str, tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)

    @thorough(60, HealthCheck.too_slow)
    @given(TEXTS)
    def check(text: str) -> None:
        refused: Exception | None = None
        try:
            with _soon():
                USES[use](text)
        except (ValueError, TypeError) as error:
            refused = error
        if refused is not None:
            sentence = str(refused)
            assert len(sentence.splitlines()) == 1
            assert len(sentence) <= 400
            assert isinstance(refused, ValueError) or "rational" in sentence

    check()
    assert list(tmp_path.iterdir()) == []
