"""Landings at a plateau: their small terms by quadrature, and returns with and without them."""

from fractions import Fraction
from functools import cache

import pytest

pytest.importorskip("flint")

from flint import arb
from mpmath import mp, mpf
from mpmath_numbers import rational
from needs import NIGHTLY_TOY, SLOW_TOY

from pwmap.checking import Refused
from woodpecker import Toy, shoot
from woodpecker.checking.certificate import check
from woodpecker.checking.intervals import Context, I
from woodpecker.checking.plateaus import Landing
from woodpecker.enclosures.balls import fraction
from woodpecker.enclosures.following import follow
from woodpecker.enclosures.forms import VALUE, S, precision
from woodpecker.enclosures.model import BallToy
from woodpecker.enclosures.plateaus import landed
from woodpecker.enclosures.taylor import Frame
from woodpecker.proofs import NotProved
from woodpecker.proofs.branches import ProvedBranch, prove_along
from woodpecker.proofs.certificates import of_branch
from woodpecker.proofs.pieces import Fractions
from woodpecker.proofs.proving import sealed

KAPPA, SLIDING, TURN = -209800, -57000, 31000  # 1/s^2, near those of the toy
SIGMAS = (2e-5, 3e-4)  # s
SIDES = pytest.mark.parametrize("late", [True, False])
# eps_N1, phi_S of starts that land close to a plateau, late and early, on both sides of the cycle
STARTS = [
    ("0.21434455", "-0.682418613075"),
    ("0.2143446", "-0.682418511010"),
    ("0.2378891783", "-0.643131223091"),
    ("0.4423271491", "-0.539547599186"),
    ("0.4423272", "-0.539547589"),
    ("0.6485490322", "-0.518581253530"),
]


def s(k: int, t: mpf, kappa: int) -> mpf:
    """s_k by its series."""
    return mp.fsum(mpf(kappa) ** n * t ** (2 * n + k) / mp.factorial(2 * n + k) for n in range(20))


def terms(eta: mpf, late: bool) -> tuple[mpf, mpf]:
    """V and A by quadrature of the gap, from events that are found as roots."""
    sigma = mp.findroot(lambda t: s(3, t, KAPPA) - abs(eta), mp.cbrt(6 * abs(eta)))

    def fall(t: mpf) -> mpf:
        return eta - s(3, t, KAPPA)

    def weighed(f: object, low: mpf, high: mpf) -> tuple[mpf, mpf]:
        return (mp.quad(lambda t: s(0, t, SLIDING) * f(t), [low, high]),  # type: ignore[operator]
                -mp.quad(lambda t: s(1, t, SLIDING) * f(t), [low, high]))  # type: ignore[operator]  # fmt: skip

    if late:
        return weighed(fall, mpf(0), sigma)
    bend, turn = s(1, sigma, KAPPA), s(0, sigma, KAPPA) - TURN * s(2, sigma, KAPPA)

    def flight(t: mpf) -> mpf:
        return bend * s(2, t + sigma, KAPPA) - turn * s(3, t + sigma, KAPPA)

    end = mp.findroot(flight, 2 * sigma)
    v, a = weighed(flight, -sigma, end)
    v_0, a_0 = weighed(fall, -sigma, mpf(0))
    return v - v_0, a - a_0


@pytest.mark.nightly
@SIDES
@pytest.mark.parametrize("sigma", SIGMAS)
def test_small_terms_hold_their_integrals(late: bool, sigma: float) -> None:
    """In both programs; their ranges are narrow, to the part |kappa| sigma^2 of
    sigma^4, sigma^5, sigma and sigma^2.
    """
    with mp.workdps(50), precision(128):
        eta = s(3, mpf(sigma), KAPPA) * (1 if late else -1)
        step = eta / 10**8
        above, below, known = terms(eta + step, late), terms(eta - step, late), terms(eta, late)
        slopes = [(a - b) / (2 * step) for a, b in zip(above, below, strict=True)]
        expected = [rational(x) for x in (*known, *slopes)]
        ball = arb(int(eta * mpf(2) ** 200)) / arb(2) ** 200
        numbers = arb(KAPPA), arb(SLIDING), arb(TURN)
        touch = landed(ball, late, *numbers)
        Context.bits = 200
        other = Landing(I.of(rational(eta)), late, I.of(KAPPA), I.of(SLIDING), I.of(TURN))
        found = [touch.velocity, touch.place, touch.velocity_slope, touch.place_slope]
        ranges = [(fraction(x.lower()), fraction(x.upper())) for x in found]
        again = [other.velocity, other.place, other.velocity_slope, other.place_slope]
        unit = Fraction(1, 2**200)
        ranges += [(x.a * unit, x.b * unit) for x in again]
    sizes = [Fraction(sigma) ** n for n in (4, 5, 1, 2)]
    width = 250 * abs(KAPPA) * Fraction(sigma) ** 2 + Fraction(1, 10**12)
    for (low, high), x, size in zip(ranges, expected * 2, sizes * 2, strict=True):
        slack = abs(x) / 10**13  # of the difference quotients
        assert low - slack <= x <= high + slack
        assert high - low < width * size


@pytest.mark.nightly
@SIDES
def test_small_terms_hold_over_a_range_and_vanish_on_the_other_side(late: bool) -> None:
    side = 1 if late else -1
    with mp.workdps(50), precision(128):
        most = s(3, mpf(1e-4), KAPPA)
        ball = arb(0, 1).union(arb(0)) * (arb(int(most * mpf(2) ** 200)) / arb(2) ** 200)
        numbers = arb(KAPPA), arb(SLIDING), arb(TURN)
        touch = landed(ball, late, *numbers)
        for part in (mpf(1), mpf(1) / 2, mpf(1) / 1000):
            v, a = terms(side * most * part, late)
            for effect, x in ((touch.velocity, v), (touch.place, a)):
                assert fraction(effect.lower()) <= rational(x) <= fraction(effect.upper())
            assert touch.velocity_slope.contains(0)
            assert touch.place_slope.contains(0)
        nothing = landed((abs(ball) + 1) * (-1 if late else 1), late, *numbers)
        assert nothing.sigma.is_zero()
        assert nothing.velocity.is_zero()


@pytest.mark.parametrize(("eps", "x"), STARTS)
def test_returns_with_plateaus_hold_those_without(eps: str, x: str) -> None:
    """The image, its slope, the period and the drop at one start, where events can be taken singly.

    The widths are those of V and its derivative: of the orders sigma^6 and sigma^3 of the spring.
    """
    with precision(140):
        frame = Frame(arb(0), arb(0))
        model = BallToy(Toy(), "eps_n1", frame, [arb(eps)])
        (sharp,) = follow(model, frame, [arb(x)])
        (whole,) = follow(model, frame, [arb(x)], plateaus=True)
        assert whole.word == sharp.word
        assert any(fired.plateau for fired in whole.log)
        for name in ("image", "time", "drop"):
            one, other = getattr(sharp, name), getattr(whole, name)
            for part in (VALUE, S):
                assert other.parts[part].box.contains(one.parts[part].box)
        assert whole.image.parts[VALUE].box.rad() < 1e-9
        assert whole.image.parts[S].box.rad() < 1e-3


def test_a_plateau_between_has_both_words_in_one_piece() -> None:
    with precision(140):
        frame = Frame(arb(0, 1e-9), arb(0, 2e-8), terms=2)
        model = BallToy(Toy(), "eps_n1", frame, [arb("0.2143445799"), arb(1)])
        ways = follow(model, frame, [arb("-0.682418551989")], plateaus=True)
        assert [way.forks[0].side for way in ways] == [1, -1]
        for way, end in zip(ways, ("D3 I2 J2", "I2 D2 I2 J2"), strict=True):
            assert way.word.endswith(end)
        with pytest.raises(NotProved):
            follow(model, frame, [arb("-0.682418551989")])


@cache
def through_a_plateau() -> ProvedBranch:
    low = Fraction("0.2143445")
    x = shoot(Toy(eps_n1=float(low)), -0.68242).phi_s
    with precision(128):
        return prove_along(
            Toy(), "eps_n1", Fractions(low, Fraction("0.2143448")), [x], lambda done: None
        )


@SLOW_TOY
def test_a_branch_goes_through_a_plateau_without_a_gap() -> None:
    branch = through_a_plateau()
    assert branch.gaps == []
    assert all(piece.turn is None for piece in branch.pieces)  # none holds a flip
    both = [piece for piece in branch.pieces if max(map(len, piece.ways)) == 2]
    assert both
    assert all(abs(piece.multiplier) < 1 for piece in branch.pieces)
    certificate = sealed(of_branch(branch, 35))
    assert "without a gap, with no flip" in check(dict(certificate.content))


@NIGHTLY_TOY
def test_a_landing_on_the_other_side_is_refused() -> None:
    """With one of both ways left out, or a late landing called an early one."""
    content = of_branch(through_a_plateau(), 35)
    pieces = content.pop("pieces")
    k = next(k for k, piece in enumerate(pieces) if len(piece["points"][0]["ways"]) == 2)
    ways = pieces[k]["points"][0]["ways"]
    for tampered in (ways[:1], ways[1:], [ways[0], ways[0]]):
        point = {**pieces[k]["points"][0], "ways": tampered}
        changed = [*pieces[:k], {**pieces[k], "points": [point]}, *pieces[k + 1 :]]
        with pytest.raises(Refused, match=r"a decision is open|not those of one decision"):
            check(dict(sealed({**content, "pieces": changed}).content))
