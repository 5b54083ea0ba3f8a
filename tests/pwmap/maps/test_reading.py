"""Text and expressions as maps: what is read, what is refused, and that none of it is executed."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
import sympy
from sympy import Abs, Max, Min, Piecewise, Rational, Symbol, symbols
from typer.testing import CliRunner

from pwmap import (
    PiecewiseLinearMap,
    UndecidedError,
    bifurcation_diagram,
    parameter_cells,
    parameter_plane,
)
from pwmap.cli.app import app

A, R, X = symbols("a r x")
read = PiecewiseLinearMap.from_sympy


def rows(map_: PiecewiseLinearMap) -> list[str]:
    """Formula and domain of each piece."""
    return [f"{piece.expression} for {piece.condition()}" for piece in map_.pieces]


# --- Nothing is executed --------------------------------------------------------------------------

ATTACKS = [
    "sqrt.__globals__['__builtins__']['__import__']('os').system('touch owned')",
    "x.subs.__func__.__globals__['sympify']('__import__(\"os\").system(\"touch owned\")')",
    "x.as_poly.__globals__", "Piecewise.__new__.__globals__",
    "__import__('os').system('touch owned')", "open('owned', 'w')",
    "(lambda: open('owned', 'w'))()", "[open('owned', 'w') for _ in 'x']",
    "{x: open('owned', 'w')}", "f\"{open('owned', 'w')}\"", "(y := open('owned', 'w'))", "x[0]",
    "x.real", "'x'", "b'x'", "*x", "Max(*x)", "Max(key=x)", "await x", "yield x", "print(x)",
    "eval(x)", "x if x else x", "x; x", "x\\\nx", "import os", "x @ x", "x // 2", "x % 2", "x << 2",
    "...", "None", "x\x00", "\ud800x", "x\u202e", "`x`", "$x", "x!", "0x10*x", "1_000*x", "1j*x",
]  # fmt: skip


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """No text leaves a file behind."""
    monkeypatch.chdir(tmp_path)
    yield
    assert not (tmp_path / "owned").exists()


@pytest.mark.parametrize("text", ATTACKS)
def test_text_that_is_no_formula_is_refused_everywhere(text: str) -> None:
    map_ = PiecewiseLinearMap([("r - 2", "x <= 0"), ("r - a*x", "x > 0")], given=["a > 1"])
    attempts = [
        lambda: read(text),
        lambda: PiecewiseLinearMap([(text, True)]),
        lambda: PiecewiseLinearMap([("x", text)]),
        lambda: read("a*x", given=[text]),
        lambda: map_.at({"a": text}),
        lambda: map_.at({"a": 2, "r": 1})(text),
        lambda: map_.at({"a": 2, "r": 1}).limit(text, "+"),
        lambda: map_.at({"a": 2, "r": 1}).word_of(text),
        lambda: parameter_cells(map_.at({"a": 2}), "r", span=(text, 3)),
        lambda: parameter_cells(map_, "r", sample={"a": text}),
        lambda: bifurcation_diagram(map_.at({"a": 2}), "r", span=(0, text)),
        lambda: parameter_plane(map_, "a", "r", (text, 2), (0, 1)),
    ]
    for attempt in attempts:
        with pytest.raises(ValueError, match=r".") as refused:
            attempt()
        sentence = str(refused.value)
        assert len(sentence) < 400
        assert len(sentence.splitlines()) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments",
    [
        (ATTACKS[0], "--parameter", "r"),
        ("r*x", "--parameter", "r", "--given", ATTACKS[0]),
        ("r*x + a", "--parameter", "r", "--set", f"a={ATTACKS[0]}"),
        ("r*x", "--parameter", "r", "--span", ATTACKS[0], "1"),
        ("r*x", "--parameter", "r", "--variable", ATTACKS[0]),
    ],
)
def test_nor_is_it_executed_on_the_command_line(arguments: tuple[str, ...]) -> None:
    found = CliRunner().invoke(app, ["analyse", *arguments])
    assert found.exit_code == 2
    assert found.output.startswith("Error: ")
    assert len(found.output.strip().splitlines()) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("9**9**9", "20000 bits"),
        ("7**7**8", "20000 bits"),
        ("2**(-9**9)", "20000 bits"),
        ("((2**64)**64)**64", "20000 bits"),
        ("x*" + "9" * 10**6, "has 1000002 characters"),
        ("x*" + "9" * 5000, "5000 digits"),
        ("(3*10**6)!", "'!' has no meaning"),
        ("a**65*x", "degree may be at most 64"),
        ("((a+b+c+d)**64)**64", "too large to be multiplied out"),
        ("((a+b+c+d)**60)*x", "too large to be multiplied out"),
        ("(" * 200 + "x" + ")" * 200, "nested more than 100 deep"),
        ("-~" * 200 + "x", "nested more than 100 deep"),
        ("x" + "**2" * 200, "nested more than 100 deep"),
        ("x" * 10**6, "has 1000000 characters"),
        ("+".join(f"a{i}" for i in range(100)), "64 parameters"),
        ("+".join(f"x/{n}" for n in range(1, 5000)), "too large to be multiplied out|20000 bits"),
        ("+".join(f"Abs(x - {n})" for n in range(1001)), "1000 breaks|too large"),
    ],
    ids=range(17),
)  # fmt: skip
def test_texts_that_would_take_for_ever_are_refused(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message) as refused:
        read(text)
    assert len(str(refused.value)) < 400


@pytest.mark.nightly
def test_long_and_deep_texts_that_are_cheap_are_read() -> None:
    assert read("+".join(["x"] * 20_000))(1) == 20_000
    assert read("(" * 90 + "x" + ")" * 90)(3) == 3
    assert read("-" * 10_001 + "x")(3) == -3
    assert read("(x + 1)**2 - x**2 - 2*x")(5) == 1
    assert read(f"{'9' * 999}*x")(1) == 10**999 - 1
    abs_ = read("+".join(f"Abs(x - {n})" for n in range(40)))
    assert len(abs_.pieces) == 41
    assert abs_(Rational(1, 2)) == sum(abs(n - Rational(1, 2)) for n in range(40))


@pytest.mark.slow
def test_expressions_are_bounded_as_texts_are() -> None:
    a, b, c, d = symbols("a b c d")
    with pytest.raises(ValueError, match="degree may be at most 64, here it would be 4096"):
        read(((a + b + c + d) ** 64) ** 64)
    nested: Any = X
    for n in range(1000):
        nested = Piecewise((nested, n > X), (1, True), evaluate=False)
    with pytest.raises(ValueError, match="nested more than 100 deep"):
        read(nested)
    doubled: Any = X  # 2**60 leaves, 60 parts
    for _ in range(60):
        doubled = sympy.Add(doubled, doubled, evaluate=False)
    assert read(doubled)(1) == 2**60
    with pytest.raises(ValueError, match="20000 bits"):
        read(2**30000 * X)


# --- What is read ---------------------------------------------------------------------------------


MAPS = {  # formula and domain of each piece
    "Piecewise((r - 2, x <= 0), (r - 2*x, x > 0))": "r - 2 for x <= 0; r - 2*x for 0 < x",
    "Piecewise((r, x < 0), (x, x < 1), (2, True))": "r for x < 0; x for 0 <= x < 1; 2 for 1 <= x",
    "Piecewise((x, 0 <= x < 1), (1, x >= 1), (0, True))":
        "0 for x < 0; x for 0 <= x < 1; 1 for 1 <= x",
    "r - a*Abs(x)": "a*x + r for x < 0; -a*x + r for 0 <= x",
    "Max(x, -2*x)": "-2*x for x < 0; x for 0 <= x",
    "r - a*abs(x)": "a*x + r for x < 0; -a*x + r for 0 <= x",
    "min(1, max(0, x))": "0 for x < 0; x for 0 <= x < 1; 1 for 1 <= x",
    "Min(1, Max(0, x))": "0 for x < 0; x for 0 <= x < 1; 1 for 1 <= x",
    "1 + Piecewise((0, x < 0), (x, True))": "1 for x < 0; x + 1 for 0 <= x",
    "Piecewise((Abs(x), x < 1), (0, True))": "-x for x < 0; x for 0 <= x < 1; 0 for 1 <= x",
    "Abs(x) + Max(-2*x, x)": "-3*x for x < 0; 2*x for 0 <= x",
    "Piecewise((1, Eq(x, 0)), (x, True))": "x for x < 0; 1 for x = 0; x for 0 < x",
    "Piecewise((1, Abs(x) < 1), (0, True))": "0 for x <= -1; 1 for -1 < x < 1; 0 for 1 <= x",
    "Piecewise((1, Ne(x, 0) & ~(x > 0)), (0, True))": "1 for x < 0; 0 for 0 <= x",
    "Piecewise((1, not x >= 0 and x > -1 or x > 3), (0, True))":
        "0 for x <= -1; 1 for -1 < x < 0; 0 for 0 <= x <= 3; 1 for 3 < x",
    "Piecewise((1, Or(Lt(x, 0), Ge(x, 1))), (0, True))":
        "1 for x < 0; 0 for 0 <= x < 1; 1 for 1 <= x",
    "Piecewise((1, 0 < 2*x < 1), (0, True))": "0 for x <= 0; 1 for 0 < x < 1/2; 0 for 1/2 <= x",
    "Rational(1, 3)*x - Rational(1/2) + Integer(-2)": "x/3 - 5/2 for all x",
    "-x**2 + x*x + 2**-1*x": "x/2 for all x",
    "lambda*x": "lambda*x for all x",
    "Max(Abs(x) - 1, 2*x)": "-x - 1 for x < -1/3; 2*x for -1/3 <= x",
    "Max(Abs(x) - 1, -2*x)": "-2*x for x < 1/3; x - 1 for 1/3 <= x",
    " \n Piecewise(\n (1, x < 0),\t(2, True),\n) ": "1 for x < 0; 2 for 0 <= x",
}  # fmt: skip


@pytest.mark.parametrize(("text", "expected"), MAPS.items())
def test_texts_that_are_maps(text: str, expected: str) -> None:
    assert "; ".join(rows(read(text))) == expected


@pytest.mark.parametrize(
    "expression",
    [
        R - A * Abs(X),
        Max(X, -2 * X),
        Min(1, Max(0, X)) + R,
        1 + Piecewise((R, X < 0), (X, X < 1), (2, True)),
        Piecewise((1, (X < 0) | (X > 1)), (0, True)),
        (X + 1) ** 2 - X**2,
        Piecewise((Piecewise((1, X < -1), (2, True)), X < 0), (Abs(X - 1), True)),
    ],
)
def test_expressions_and_their_text_are_the_same_map(expression: sympy.Expr) -> None:
    assert str(read(expression)) == str(read(str(expression)))
    for x in (Rational(n, 4) for n in range(-12, 13)):
        expected = expression.subs(X, x)
        assert sympy.expand(read(expression)(x) - expected) == 0, x


def test_a_continuous_formula_has_no_pieces_of_its_own_at_its_kinks() -> None:
    tent = read("Min(2*x, 2 - 2*x)")
    assert rows(tent) == ["2*x for x < 1/2", "2 - 2*x for 1/2 <= x"]
    assert rows(read("Min(2 - 2*x, 2*x)")) == rows(tent)
    assert [p.word for p in tent.iterate(2).fixed_points()] == ["LL", "LR", "RR", "RL"]


def test_breaks_between_parameters_are_ordered_by_the_assumptions() -> None:
    with pytest.raises(UndecidedError, match="no certain order"):
        read("Abs(x - a) + Abs(x - b)")
    assert rows(read("Abs(x - a) + Abs(x - b)", given=["a < b"])) == [
        "a + b - 2*x for x < a",
        "-a + b for a <= x < b",
        "-a - b + 2*x for b <= x",
    ]
    with pytest.raises(UndecidedError, match=r"sign of 2\*a"):
        read("Abs(a*x)")
    assert rows(read("Abs(a*x)", given=["a > 0"])) == ["-a*x for x < 0", "a*x for 0 <= x"]


def test_parameters_meet_under_assumptions() -> None:
    """Breaks lie where arguments meet; arguments that lose everywhere leave none."""
    assert rows(read("Max(a*x, b*x + 1, 1 - x)", given=["a > b", "b > 0"])) == [
        "1 - x for x < 0", "b*x + 1 for 0 <= x < 1/(a - b)", "a*x for 1/(a - b) <= x",
    ]  # fmt: skip
    assert rows(read("Min(x, a, b)", given=["a < b"])) == ["x for x < a", "a for a <= x"]
    assert rows(read("Abs(a)*x + 1", given=["a < 0"])) == ["-a*x + 1 for all x"]
    sentence = r"what Abs\(a\) is does not follow .* must say the sign of 2\*a \(given\)"
    with pytest.raises(ValueError, match=sentence):
        read("Abs(a)*x + 1")


# --- Names ----------------------------------------------------------------------------------------


class HalfMade:
    """An object whose text needs an attribute that was never set."""

    def __repr__(self) -> str:
        return str(self.text)  # type: ignore[attr-defined]


class TooLarge:
    """An object for whose text there is not enough memory."""

    def __repr__(self) -> str:
        raise MemoryError


def test_an_object_that_has_no_text_is_named_by_its_type() -> None:
    for given in ([X], HalfMade()):
        with pytest.raises(ValueError, match=r"expected text.*, got (\[x\]|.* of type HalfMade)$"):
            read(given, X)  # type: ignore[arg-type]
    with pytest.raises(MemoryError):
        read(TooLarge(), X)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "name", ["nan", "oo", "zoo", "inf", "I", "pi", "E", "None", "Max", "infinity", "NaN"]
)
def test_constants_do_not_become_parameters(name: str) -> None:
    """Nor do symbols of such names, whose formulas would be read as of other numbers."""
    refused = f"{name} cannot be the name of a variable or param"
    for text in (f"{name}*x", f"Piecewise((1, x < {name}), (2, True))", Symbol(name) * X):
        with pytest.raises(ValueError, match=refused):
            read(text)
    with pytest.raises(ValueError, match=refused):
        read(2 * Symbol(name), Symbol(name))
    with pytest.raises(ValueError, match=refused):
        read("a*x", given=[Symbol(name) > 0])
    with pytest.raises(ValueError, match="the variable must be a symbol such as x: "):
        read("1", name)


def test_names_are_compared_as_python_compares_them() -> None:
    micro, mu = "µ", "μ"
    assert micro != mu
    for written in (micro, mu, Symbol(micro), Symbol(mu)):
        map_ = read(Symbol("x") * written if isinstance(written, Symbol) else f"{written}*x")
        for key in (micro, mu, Symbol(micro), Symbol(mu)):
            assert map_.at({key: 3})(2) == 6
            assert parameter_cells(map_, key).edges == (-1, 1)
    assert read("µ*x + μ*x").parameters == (Symbol(mu),)


@pytest.mark.parametrize("text", ["x²", "2x", "x y", "a(x)", "x^2", "(x)(x)", "x.", "a.b"])
def test_what_other_notations_mean_is_not_guessed(text: str) -> None:
    with pytest.raises((ValueError, TypeError), match=r"cannot read|has no|float"):
        read(text)


def test_floats_in_text_are_refused_by_the_rational_they_mean() -> None:
    for text in (
        "Rational(0.1)*x",
        "0.1*x",
        ".1*x",
        "1e-1*x",
        "Piecewise((x, x < 0.1), (1, True))",
    ):
        with pytest.raises(TypeError, match=r"is a float, .* write the rational 1/10 instead"):
            read(text)
    with pytest.raises(TypeError, match=r"1e999999999 is a float, .* write a rational instead"):
        read("1e999999999*x")
    with pytest.raises(TypeError, match=r"is a float, .* write a rational instead"):
        read(sympy.Float(10) ** 10**6 * X)


def test_assumptions_on_parameters_that_do_not_occur_say_nothing() -> None:
    map_ = read("a*x", given=["b > 1", "a > b", "a > 0"])
    assert map_.parameters == (A,)
    assert map_.given == (A > 0,)
    with pytest.raises(ValueError, match="no values of the parameters with b > 1, b < 1"):
        read("a*x", given=["b > 1", "b < 1"])
    with pytest.raises(ValueError, match="must be an inequality such as a > 1, got b"):
        read("a*x", given=["b"])
    assert read("x", given=["b > 1"]).given == ()


@pytest.mark.parametrize(
    "value", [Fraction(5, 4), Rational(5, 4), "5/4", "Rational(5, 4)", "1 + 1/4"]
)
def test_values_of_parameters(value: object) -> None:
    assert read("a*x").at({"a": value})(4) == 5


def test_a_point_where_a_nested_formula_agrees_with_the_one_beside_is_no_piece() -> None:
    nested = "1 + Piecewise((x, x < 0), (0, Eq(x, 0)), (2*x, True))"
    pieces = PiecewiseLinearMap.from_sympy(nested).pieces
    assert [str(piece) for piece in pieces] == ["L: x + 1 for x < 0", "R: 2*x + 1 for 0 <= x"]
