"""Proofs in ball arithmetic, and the forms that they are made of, against what is known."""

import math
from fractions import Fraction
from functools import cache
from random import Random

import pytest
import sympy

pytest.importorskip("flint")

from flint import arb
from mpmath import mp, mpf
from mpmath_numbers import rational as exactly
from needs import NEEDS_NUMBA, NIGHTLY_TOY, SLOW_TOY
from toy_points import EVERY, POINTS

from pwmap.diagrams.diagram import BranchKind, Diagram, PointKind, SpecialPoint
from woodpecker import Toy, bifurcation_diagram, continuation, prove, shoot
from woodpecker.checking.certificate import check
from woodpecker.checking.intervals import I, shapes, unit, wave
from woodpecker.checking.toy import PAPER as CHECKED
from woodpecker.enclosures.balls import fraction
from woodpecker.enclosures.forms import precision, start, varying
from woodpecker.enclosures.model import data, rational
from woodpecker.enclosures.stumpff import shape_balls, stumpff_balls
from woodpecker.enclosures.taylor import Frame
from woodpecker.proofs import NotProved
from woodpecker.proofs.branches import prove_along
from woodpecker.proofs.certificates import of_branch, text
from woodpecker.proofs.pieces import Fractions, Route, Tube, curves_near, proved
from woodpecker.proofs.proving import sealed


def ends(ball: arb) -> tuple[Fraction, Fraction]:
    return fraction(ball.lower()), fraction(ball.upper())


def holds(ball: arb, x: mpf, room: Fraction = Fraction(1, 10**27)) -> bool:
    low, high = ends(ball)
    return low - room <= exactly(x) <= high + room


@pytest.mark.slow
@pytest.mark.parametrize("kappa", [-209800, 532, -1])
def test_both_programs_hold_stumpffs_functions(kappa: int) -> None:
    """Against their series, with enough digits for all of its cancellation."""
    with mp.workdps(150), precision(128), unit(140):
        for t in (1e-9, 1e-3, 0.02, 0.3):
            x, time = kappa * mpf(t) ** 2, I.of(Fraction(t))
            c = [mp.fsum(x**n / mp.factorial(2 * n + k) for n in range(400)) for k in range(6)]
            for k, found in enumerate(wave(I.of(kappa), time)):
                assert found.a <= mpf(t) ** k * c[k] * 2**140 <= found.b
            if abs(x) < 60:
                for k, found in enumerate(shapes(I.of(kappa) * time.power(2), 5)):
                    assert found.a <= c[k] * 2**140 <= found.b
            for k, ball in enumerate(stumpff_balls(arb(kappa), arb(t), 4)):
                assert holds(ball, mpf(t) ** k * c[k], Fraction(0))
                assert ball.rad() < 1e-30
            for k, ball in enumerate(shape_balls(arb(kappa) * arb(t) ** 2, 4)):
                assert holds(ball, c[k], Fraction(0))


@pytest.mark.slow
def test_forms_hold_values_and_derivatives_over_their_box() -> None:
    """All six against sympy, at random rational places of the box."""
    s, q = sympy.symbols("s q")
    x, p = sympy.Rational(3, 10) + 2 * q + s, 1 + q
    f = x**2 * p / (p + 3 * x)
    known = [f, f.diff(s), f.diff(q), f.diff(s, 2), f.diff(s, q), f.diff(q, 2)]
    rng = Random(3)
    with precision(128):
        frame = Frame(arb(0, 0.001), arb(0, 0.02), terms=4, depth=6)
        a, b = start(frame, [arb(3) / 10, arb(2)]), varying(frame, [arb(1), arb(1)])
        form = a * a * b / (b + a * 3)
        for _ in range(30):
            place = {s: sympy.Rational(rng.randrange(-10, 11), 10**4),
                     q: sympy.Rational(rng.randrange(-200, 201), 10**4)}  # fmt: skip
            for k, function in enumerate(known):
                exact_value = function.subs(place)
                there = Fraction(int(exact_value.p), int(exact_value.q))
                low, high = ends(form.box if k == 0 else form.parts[k].box)
                assert low <= there <= high
                assert high - low < Fraction(1, 2)


def test_data_are_the_decimals_of_the_paper() -> None:
    assert rational(0.0003) == Fraction(3, 10000)
    assert rational(5e-9) == Fraction(5, 10**9)
    assert text(Fraction(-3, 8)) == "-0.375"
    assert text(Fraction(1, 3)) == "1/3"
    assert data(Toy()) == CHECKED  # the checker has its own table of them


@NIGHTLY_TOY
def test_the_stable_cycle() -> None:
    certificate = prove(shoot(Toy(eps_n1=0.5), -0.53))
    content = certificate.content
    outer, inner = content["outer"]["points"][0], content["inner"]["points"][0]
    centre, radius = Fraction(outer["curve"][0]), Fraction(outer["radius"])
    known = Fraction("-0.52947197")
    assert centre - radius <= known - Fraction(1, 10**8)
    assert known + Fraction(1, 10**8) <= centre + radius
    assert abs(Fraction(inner["curve"][0]) - known) < Fraction(1, 10**8)
    assert inner["ways"][0]["word"] == "S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2"
    low, high = (Fraction(x) for x in content["multiplier"])
    assert Fraction("-0.83917") < low < high < Fraction("-0.83915")
    low, high = (Fraction(x) for x in content["period"])
    assert high - low < Fraction(1, 10**12)
    assert low < Fraction("0.14597607") < high + Fraction(1, 10**8)
    assert content["stable"] is True
    assert check(content) == certificate.statement


@NIGHTLY_TOY
def test_a_cycle_of_two_returns_and_an_unstable_one() -> None:
    orbit = shoot(Toy(eps_n1=0.66), -0.53, 2)
    assert orbit.minimal_period == 2
    content = prove(orbit).content
    assert content["stable"] is True
    assert "exactly one cycle of 2 points" in check(content)
    steep = prove(shoot(Toy(eps_n1=0.66), -1.02753, 2))
    assert steep.content["stable"] is False
    assert float(Fraction(steep.content["multiplier"][0])) == pytest.approx(-1398.76, abs=0.01)


@NIGHTLY_TOY
@pytest.mark.parametrize(
    ("law", "name"), [each for each in EVERY if each != ("separate", "end of the branch from A")]
)
def test_points(law: str, name: str) -> None:
    """All but one, at which impacts accumulate."""
    code, note, p, x = POINTS[law][name]
    point = SpecialPoint(id="P", kind=PointKind(code), parameter=p, x=x)
    found = prove(refined(point, law), toy=Toy(expansion_friction=law)).content
    assert (found["code"], found["note"]) == (code, note)
    for key, near in (("p", p), ("x", x)):
        low, high = (Fraction(e) for e in found[key])
        assert high - low < Fraction(1, 10**12)
        assert abs(float(low) - near) < 2e-12  # the width and the digits of the table
    assert check(found)


@cache
def diagram(law: str) -> Diagram:
    return bifurcation_diagram(Toy(expansion_friction=law), "eps_n1", (0.04, 0.5))


def refined(point: SpecialPoint, law: str) -> SpecialPoint:
    """The point of the toy's diagram near a place that is known to seven digits."""
    return min(
        diagram(law).points,
        key=lambda q: abs(q.parameter - point.parameter) + abs(q.x - point.x),
    )


@NIGHTLY_TOY
def test_a_branch_through_changes_of_its_word_and_a_flip() -> None:
    toy = Toy()
    with precision(128):
        start_ = shoot(toy.replace(eps_n1=0.3), -0.587).points
        span = Fractions(Fraction("0.3"), Fraction("0.304"))
        branch = prove_along(toy, "eps_n1", span, start_, lambda done: None)
        assert not branch.gaps
        assert {len(piece.ways[0]) for piece in branch.pieces} == {1, 2}
        words = [way.word for piece in branch.pieces for way in piece.ways[0]]
        assert set(words) == {
            "S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2", "S2 D2 I3 D3 I1 I3 D3 I2 J2"
        }  # fmt: skip
        for piece in branch.pieces:  # against Newton's method in doubles, at three places
            for part in (0, Fraction(1, 3), 1):
                p = piece.p.low + part * piece.p.length
                orbit = shoot(toy.replace(eps_n1=float(p)), -0.587)
                low, high = ends(piece.multiplier)
                assert float(low) - 1e-9 <= orbit.multiplier <= float(high) + 1e-9
        certificate = sealed(of_branch(branch, 35))
    assert check(certificate.content) == certificate.statement
    assert "without a gap, with no flip" in certificate.statement


@NIGHTLY_TOY
def test_a_flip_lies_on_one_short_piece() -> None:
    toy, span = Toy(), Fractions(Fraction("0.6485488"), Fraction("0.6485494"))
    with precision(128):
        start_ = shoot(toy.replace(eps_n1=float(span.low)), -0.51858).points
        branch = prove_along(toy, "eps_n1", span, start_, lambda done: None)
        certificate = sealed(of_branch(branch, 35))
    (piece,) = [piece for piece in branch.pieces if piece.turn is not None]
    below, above = (shoot(toy.replace(eps_n1=float(p)), -0.51858).multiplier + 1.0 for p in piece.p)
    assert below * above < 0.0
    assert check(certificate.content).endswith("without a gap, with exactly one flip.")


@SLOW_TOY
def test_the_multiplier_turns_as_the_second_derivatives_say() -> None:
    """Against differences of multipliers of orbits in doubles."""
    toy, p = Toy(), Fraction("0.65")
    with precision(128):
        line = Route.over(Fractions(p - Fraction(1, 10**6), p + Fraction(1, 10**6)))
        points = shoot(toy.replace(eps_n1=0.65), -0.518).points
        curves = curves_near(toy, "eps_n1", line, [[arb(x)] for x in points], 6)
        tubes = [Tube(curve, Fraction(1, 10**14)) for curve in curves]
        piece = proved(toy, "eps_n1", line._replace(flips=True), tubes, 6)
        low, high = ends(piece.turn)
    h = 1e-5
    left, right = (shoot(toy.replace(eps_n1=0.65 + s * h), -0.518).multiplier for s in (-1.0, 1.0))
    slope = (right - left) / (2.0 * h)
    assert float(low) - 0.05 * abs(slope) <= slope <= float(high) + 0.05 * abs(slope)


@NEEDS_NUMBA
def test_what_a_proof_would_pass_over_is_refused() -> None:
    orbit = shoot(Toy(), -0.53)
    with pytest.raises(ValueError, match="an orbit is proved of its own toy, got another toy"):
        prove(orbit, toy=Toy(mu_2=0.31))
    nowhere = SpecialPoint(id="P", kind=PointKind.BC, parameter=0.3, x=-0.6)
    for what in (orbit, nowhere):
        with pytest.raises(ValueError, match=r"a span is for a branch, got \(0.4, 0.5\) for a"):
            prove(what, (0.4, 0.5))


SPANS = {
    (0.5, 0.5): "span must ascend", (0.6, 0.5): "span must ascend",
    (0.5, math.nan): "span must ascend", (0.5, math.inf): "span must be finite",
    (0.5,): "span must be two real numbers", (): "span must be two real numbers",
    ("0.5", "0.51"): "span must be two real numbers", (0.2, 0.3): "span must begin on the branch",
    (0.5, 1.5): r"span must lie in \[0, 1\], as eps_n1 does",
    (0.5, 0.5 + 1e-15): "span must be 1e-10 long at least",
}  # fmt: skip


@NEEDS_NUMBA
def test_wrong_spans_and_points_are_refused_before_anything_is_proved() -> None:
    toy = Toy()
    (branch,) = continuation(toy, shoot(toy, -0.53), span=(0.45, 0.55)).branches
    for span, reason in SPANS.items():
        with pytest.raises(ValueError, match=f"^{reason}"):
            prove(branch, span)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="progress must be a function, got 3"):
        prove(branch, (0.5, 0.51), progress=3)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"toy must be woodpecker\.Toy, got 'summed'"):
        prove(branch, (0.5, 0.51), toy="summed")  # type: ignore[arg-type]
    for p, x in ((math.nan, -0.5), (0.1, math.nan)):
        with pytest.raises(ValueError, match="a point must have finite values, got"):
            prove(SpecialPoint(id="A", kind=PointKind.FF, parameter=p, x=x))


@NIGHTLY_TOY
def test_what_cannot_be_proved_is_said() -> None:
    with pytest.raises(ValueError, match="proofs move one of eps_n1, eps_n2, eps_n3, got 'mu_2'"):
        prove(SpecialPoint(id="P", kind=PointKind.BC, parameter=0.3, x=-0.8), parameter="mu_2")
    with pytest.raises(TypeError, match="prove needs a periodic orbit, a branch or a special"):
        prove(0.5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="only border collisions of P_1 can be proved, got PD"):
        prove(SpecialPoint(id="P", kind=PointKind.PD, parameter=0.6, x=-0.5))
    branches = diagram("summed").branches
    with pytest.raises(ValueError, match="a branch is proved over a span, got none"):
        prove(next(b for b in branches if b.kind is BranchKind.FIXED_POINT))
    with pytest.raises(ValueError, match="only branches of fixed points can be proved, got jump"):
        prove(next(b for b in branches if b.kind is BranchKind.JUMP), (0.1, 0.2))
    nowhere = SpecialPoint(id="P", kind=PointKind.BC, parameter=0.3, x=-0.6)
    with pytest.raises(NotProved, match="no two gaps close at once here"):
        prove(nowhere)
