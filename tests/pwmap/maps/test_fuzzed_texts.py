"""Random texts are maps, assumptions and values, or are refused soon and in one sentence.

Most are texts that are read, with parts of them and of others mixed in; some are long, or just any
characters.
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

READ = [  # texts of every kind that is read, and numbers and names that are none of a map
    "Piecewise((r - 2, x <= 0), (r - a*x, True))",
    "Piecewise((x, 0 <= x < 1), (1, Or(Lt(x, 0), Ge(x, 2))), (a, True))",
    "Max(Abs(x - 1/2), Min(-2*x, b)) + Rational(1, 3)*x",
    "Piecewise((1, not x >= 0 and x > -1 or x > 3), (b*(x + 1)**2 - b*x**2, True))",
    "(x > 0) & ~(Eq(x, 1) | Ne(a, b))",
    "a > b",
    "-5/4",
    "x/(a + 1)",
]
WRONG = ["9" * 1100, "0.1", "1e9999", "007", "9**9**9", "7**7**8", "**64", "µ", "lambda", "nan",
         "pi", "sqrt(2)", "f(x)", "/0", "/x", "*x", "**x"]  # fmt: skip


@st.composite
def mutated(draw: st.DrawFn) -> str:
    text = draw(st.sampled_from(READ))
    for _ in range(draw(st.integers(1, 3))):
        start = draw(st.integers(0, len(text)))
        stop = draw(st.integers(start, min(len(text), start + 4)))
        other = draw(
            st.sampled_from(["", *"[]{}.'\"\\;:=!@%^`\0\n", *WRONG, *READ, *ATTACKS])
            | st.text(max_size=3)
        )
        text = text[:start] + other + text[stop:]
    return text


LONG = st.tuples(
    st.sampled_from(["(", "Abs(", "-", "~", "x*(", "9**", "a<", "Piecewise((1, x<0), (", "x+a*"]),
    st.sampled_from([10, 100, 1000]),
).map(lambda t: t[0] * t[1] + "x" + ")" * (t[0].count("(") * t[1]))
TEXTS = st.one_of(
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
