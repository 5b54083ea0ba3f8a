"""The impact oscillator of Shaw and Holmes: period-one orbits, their fold and flip, and grazing.

    python -m studies.systems.oscillator [--fast] [--out DIR]

x'' + 2 zeta x' + x = F cos(w t), with a stop at x = sigma of restitution eps [Shaw1983]. Orbits
with one impact in a period have a closed form, and so have their folds; flips are roots of one
closed equation. Where the amplitude of the motion without impacts reaches the gap it grazes: the
slope of the stroboscopic map grows like the inverse root of the distance [Nordmark1991], so that
Newton's method fails. The germ of the map there tells which cycles are born.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import sympy
from matplotlib.figure import Figure
from matplotlib.transforms import blended_transform_factory
from scipy.optimize import brentq

from pwmap import PointKind
from pwmap.plot import plot_diagram
from studies.common.record import Results, command
from studies.common.style import GREY, WIDTH, grid, keep
from woodpecker.base.arrays import Floats
from woodpecker.search.connected import Connected
from woodpecker.systems import Contact, ContactSystem, Section, SystemMap, continuation, shoot

X, V, T = sympy.symbols("x u_x t")
W, F, EPS, SIGMA, ZETA = sympy.symbols("w F eps sigma zeta")
BASE = {W: 2.8, F: 1.0, EPS: 0.8, SIGMA: 0.5, ZETA: 0.05}


def system() -> ContactSystem:
    """The oscillator."""
    stop = Contact(name="the stop", gap=SIGMA - X, eps_n=EPS)
    return ContactSystem([X], [[1]], [F * sympy.cos(W * T) - 2 * ZETA * V - X], [stop], BASE)


def impacts(*parameters: str, backend: str | None = None) -> SystemMap:
    """From impact to impact: speed after it, and time modulo the period."""
    section = Section(when="the stop", free=[V, T], at={X: SIGMA}, period=2 * sympy.pi / W)
    return SystemMap(system(), section, parameters, backend=backend)


def strobed(*parameters: str, backend: str | None = None) -> SystemMap:
    """Once in each period of the force."""
    section = Section(when=sympy.sin(W * T), free=[X, V], at={T: 0})
    return SystemMap(system(), section, parameters, backend=backend)


class Orbit(NamedTuple):
    """A period-one orbit just after its impact."""

    v: float  # speed, negative
    t: float  # time modulo the period
    trace: float  # of the derivative of the map
    det: float


class ClosedForm(NamedTuple):
    """Orbits with one impact in n periods, for given w, eps, sigma, zeta; any F.

    The free motion y between impacts has y(0) = y(T) = c, so its speeds there are k_0 c and k_1 c;
    with the speed v after the impact, c = alpha v, and the forced motion has x_p(0) = sigma -
    alpha v and x_p'(0) = beta w v: their squares add up to that of its amplitude.
    """

    w: float
    eps: float
    sigma: float
    zeta: float
    n: int = 1

    @property
    def flow(self) -> Floats:
        """(2, 2) of the free motion over n periods."""
        z, period = self.zeta, 2.0 * math.pi * self.n / self.w
        d = math.sqrt(1.0 - z * z)
        c, s, e = math.cos(d * period), math.sin(d * period), math.exp(-z * period)
        return e * np.array([[c + z * s / d, s / d], [-s / d, c - z * s / d]])

    @property
    def numbers(self) -> tuple[float, float]:
        """Alpha and beta."""
        e = self.flow
        k_0 = (1.0 - e[0, 0]) / e[0, 1]
        k_1 = e[1, 0] + e[1, 1] * k_0
        alpha = -(1.0 + 1.0 / self.eps) / (k_1 - k_0)
        return alpha, (1.0 - alpha * k_0) / self.w

    @property
    def gain(self) -> float:
        """Amplitude of the forced motion over F."""
        return 1.0 / math.hypot(1.0 - self.w**2, 2.0 * self.zeta * self.w)

    def fold(self) -> tuple[float, float]:
        """F at the fold, and the speed there."""
        alpha, beta = self.numbers
        square = alpha**2 + beta**2
        return abs(self.sigma * beta) / math.sqrt(square) / self.gain, self.sigma * alpha / square

    def speeds(self, force: float) -> list[float]:
        """The speeds after the impact at some F; both roots."""
        alpha, beta = self.numbers
        a, b = alpha**2 + beta**2, -2.0 * self.sigma * alpha
        c = self.sigma**2 - (force * self.gain) ** 2
        root = math.sqrt(b * b - 4.0 * a * c)
        return [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)]

    def force(self, v: float) -> float:
        """F of the orbit with some speed."""
        alpha, beta = self.numbers
        return math.hypot(self.sigma - alpha * v, beta * v) / self.gain

    def orbit(self, v: float) -> Orbit:
        """The orbit with some speed after the impact, and its multipliers' sum and product."""
        alpha, beta = self.numbers
        force = self.force(v)
        lag = math.atan2(2.0 * self.zeta * self.w, 1.0 - self.w**2)  # x_p = gain F cos(w t - lag)
        place = math.atan2(-beta * v, self.sigma - alpha * v)
        t = ((place + lag) / self.w) % (2.0 * math.pi / self.w)
        pull = force * math.cos(self.w * t) - self.sigma
        before, after = -v / self.eps, v
        a_before, a_after = pull - 2.0 * self.zeta * before, pull - 2.0 * self.zeta * after
        turn = (a_after + self.eps * a_before) / before
        monodromy = np.array([[-self.eps, 0.0], [turn, -self.eps]]) @ self.flow
        return Orbit(v, t, float(np.trace(monodromy)), float(np.linalg.det(monodromy)))

    def flip(self, near: float, far: float) -> float:
        """The speed at which a multiplier is -1, between two speeds."""

        def test(v: float) -> float:
            orbit = self.orbit(v)
            return 1.0 + orbit.trace + orbit.det

        return float(brentq(test, near, far, xtol=1e-15))


def through_grazing() -> tuple[Connected, float]:
    """The stroboscopic map followed over F through the grazing, and F there."""
    exact = ClosedForm(BASE[W], BASE[EPS], BASE[SIGMA], BASE[ZETA])
    grazing = BASE[SIGMA] / exact.gain
    map_ = strobed("F")
    free = shoot(map_, [-0.1, 0.0], p=[0.7 * grazing])
    span = 0.5 * grazing, 2.0 * grazing
    return continuation(map_, free, span, [(-4, 4), (-6, 6)], orders=(1, 2, 3)), grazing


def newton_fails(distance: float) -> int:
    """How many of 40 starts beside the grazing lead Newton's method to a cycle with impacts."""
    exact = ClosedForm(BASE[W], BASE[EPS], BASE[SIGMA], BASE[ZETA])
    grazing = BASE[SIGMA] / exact.gain
    map_, p = strobed("F"), np.array([grazing * (1.0 + distance)])
    cycle = shoot(map_, [-0.4996, 0.0573], p=[grazing * (1.0 - distance)])
    rng, found = np.random.default_rng(1), 0
    for _ in range(40):
        x = cycle.x[0] + 10.0 * distance * rng.normal(size=2)
        for _ in range(30):
            image = map_.at(x, p)
            if image.reason:
                break
            x = x - np.linalg.solve(image.jacobian[:, :2] - np.eye(2), image.value - x)
        found += bool(not image.reason and np.abs(image.value - x).max() < 1e-9)
    return found


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Folds and flips of random oscillators, and the way through the grazing.

    Parameters
    ----------
    fast
        Fewer oscillators.
    out
        Folder for ``system_oscillator.png``.

    Returns
    -------
    dict
        ``oscillators``; ``fold``, ``flip``: largest differences of trace and determinant from the
        closed form at their folds and flips; ``grazing``: how far the border is from the closed
        form; ``born``: branches that start there.
    """
    count = 10 if fast else 50
    rng = np.random.default_rng(3)
    map_, worst = impacts("F"), {"fold": 0.0, "flip": 0.0}
    for _ in range(count):
        exact = random_oscillator(rng)
        for kind, orbit in special_orbits(exact):
            worst[kind] = max(worst[kind], difference(map_, exact, orbit))
    found, grazing = through_grazing()
    (graze,) = (q for q in found.diagram.points if q.kind is PointKind.BC)
    if out is not None:
        keep(draw(found, grazing), out / "system_oscillator.png")
    return {
        "oscillators": count, **worst, "grazing": graze.parameter - grazing,
        "born": len(graze.branches) - 1,
    }  # fmt: skip


def random_oscillator(rng: np.random.Generator) -> ClosedForm:
    """One with a preloaded stop: its orbits with one impact in a period have a fold, as a rule."""
    for _ in range(100):
        exact = ClosedForm(
            rng.uniform(2.2, 3.6), rng.uniform(0.3, 0.9), rng.uniform(-1.0, -0.1),
            rng.uniform(0.01, 0.2),
        )  # fmt: skip
        if exact.fold()[1] < 0.0:
            return exact
    raise ValueError("none of 100 oscillators has a fold with an impact")


def special_orbits(exact: ClosedForm) -> list[tuple[str, Orbit]]:
    """The orbits at the fold and, if there is one, at the flip."""
    _, v = exact.fold()
    found = [("fold", exact.orbit(v))]
    tests = [1.0 + o.trace + o.det for o in (exact.orbit(v), exact.orbit(20.0 * v))]
    if tests[0] * tests[1] < 0.0:
        found.append(("flip", exact.orbit(exact.flip(v, 20.0 * v))))
    return found


def difference(map_: SystemMap, exact: ClosedForm, orbit: Orbit) -> float:
    """How far a return map is from an orbit in closed form: point, trace and determinant.

    Orbits that penetrate the stop in between are those of the word prescribed.
    """
    own = map_.holding(w=exact.w, eps=exact.eps, sigma=exact.sigma, zeta=exact.zeta)
    x, p = np.array([orbit.v, orbit.t]), np.array([exact.force(orbit.v)])
    image = own.at(x, p)
    jacobian = image.jacobian[:, :2]
    period = 2.0 * math.pi / exact.w
    away = image.value - x
    away[1] -= period * round(away[1] / period)
    return float(
        max(
            np.abs(away).max(), abs(np.trace(jacobian) - orbit.trace),
            abs(np.linalg.det(jacobian) - orbit.det),
        )
    )  # fmt: skip


def draw(found: Connected, grazing: float) -> Figure:
    """Branches over F, and where the free motion grazes."""
    figure, ax = plt.subplots(figsize=(WIDTH, 4.2), layout="constrained")
    plot_diagram(found.diagram, ax)
    ax.axvline(grazing, color=GREY, linewidth=0.8)
    place = blended_transform_factory(ax.transData, ax.transAxes)
    ax.text(grazing, 0.03, " amplitude = gap", transform=place)
    ax.set(xlabel="amplitude $F$ of the force", ylabel="$x$ once in each period")
    grid(ax)
    return figure


if __name__ == "__main__":
    command(main, "system_oscillator")
