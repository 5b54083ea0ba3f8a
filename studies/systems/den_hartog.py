"""Den Hartog's oscillator with dry friction: response with and without stops.

    python -m studies.systems.den_hartog [--fast] [--out DIR]

x'' + x + f sign(x') = cos(w t), with friction at a contact that a weight of 1 keeps closed
[DenHartog1931]. Without stops the amplitude is sqrt(V**2 - (f H)**2) with V = 1/(1 - w**2) and
H = sin(pi/w)/(w (1 + cos(pi/w))); stops begin at f = |V|/sqrt(H**2 + w**-4).
With two stops in a period there is no closed form: phase and duration of a slide from rest to rest
solve two equations, here with thirty digits.

At the border between both, let m = cos(w t) + A - f be the excess of the force over friction where
the motion turns back at -A, and j > 0 its rate. For m > 0 the mass returns with
u = m t + j t**2/2; for m < 0 it rests until t = -m/j and then has u = j (t + m/j)**2/2. The two
differ by m**2/(2 j): value and slope of the return agree on both sides, and only its second
derivative jumps. So the branch continues, and the border is a change of word, not a special point.
The slope has a closed form: a turn maps a perturbation (dx, du) to (dx, 0), because u' = 0 after
it, and a slide rotates it by R(pi/w), since friction is constant; the multipliers are 0 and
cos(pi/w)**2.
"""

from __future__ import annotations

import math
from pathlib import Path

import mpmath
import numpy as np
import sympy
from matplotlib.figure import Figure

from pwmap import Diagram
from studies.common.record import Results, command
from studies.common.style import RED, STABLE, canvas, keep
from woodpecker.base.arrays import Floats
from woodpecker.systems import (
    Contact,
    ContactSystem,
    Section,
    SystemMap,
    continuation,
    shoot,
    simulate,
)

X, Y, V, T, W, FRICTION = sympy.symbols("x y u_x t w f")


def system() -> ContactSystem:
    """The oscillator; its normal force is 1."""
    ground = Contact(name="the ground", gap=Y, slip=V, mu=FRICTION)
    return ContactSystem(
        [X, Y], [[1, 0], [0, 1]], [sympy.cos(W * T) - X, -1], [ground], {W: 0.6, FRICTION: 0.2}
    )


def map_of(*parameters: str, backend: str | None = None) -> SystemMap:
    """Once in each period of the force."""
    section = Section(when=sympy.sin(W * T), free=[X, V], at={T: 0}, horizon=50.0)
    return SystemMap(system(), section, parameters, backend=backend)


def numbers(w: float) -> tuple[float, float]:
    """V and H."""
    turn = math.pi / w
    return 1.0 / (1.0 - w * w), math.sin(turn) / (w * (1.0 + math.cos(turn)))


def exact_amplitude(w: float, f: float) -> float:
    """Without stops."""
    v, h = numbers(w)
    return math.sqrt(v * v - (f * h) ** 2)


def stops_from(w: float) -> float:
    """The friction from which on the motion stops twice in a period."""
    v, h = numbers(w)
    return abs(v) / math.hypot(h, w**-2)


def at_border(w: float) -> tuple[Floats, Floats]:
    """The motion with which stops begin: (x, u) at phase 0 of the force, and the slope (2, 2)."""
    f, (v, _), turn = stops_from(w), numbers(w), math.pi / w
    most = exact_amplitude(w, f)
    phase = 2.0 * math.pi - math.acos(f - most)  # of the force where it turns back at -most
    s = (2.0 * math.pi - phase) / w  # from there to phase 0, less than `turn`
    forced = v * np.array([math.cos(phase), -w * math.sin(phase)])
    point = turned(s) @ (np.array([f - most, 0.0]) - forced) + [v - f, 0.0]
    forgets = np.diag([1.0, 0.0])
    return point, turned(s) @ forgets @ turned(turn) @ forgets @ turned(turn - s)


def turned(t: float) -> Floats:
    """What a time makes of a small change (dx, du) of a free motion."""
    return np.array([[math.cos(t), math.sin(t)], [-math.sin(t), math.cos(t)]])


def amplitude_with_stops(w: float, f: float, steps: int = 8) -> float:
    """With one stop in each half of the period, for w < 1; from where stops begin in some steps."""
    least, turn = stops_from(w), math.pi / w
    phase, time = 2.0 * math.pi - math.acos(least - exact_amplitude(w, least)), turn
    with mpmath.workdps(30):
        w_, guess = mpmath.mpf(w), (mpmath.mpf(phase), mpmath.mpf(time))
        for k in range(1, steps + 1):
            friction = mpmath.mpf(least) + (mpmath.mpf(f) - least) * k / steps

            def rest(phase: mpmath.mpf, s: mpmath.mpf, f_: mpmath.mpf = friction) -> list[object]:
                """Speed, and place less the amplitude, where a slide from -amplitude ends."""
                v, size, end = 1 / (1 - w_**2), f_ - mpmath.cos(phase), phase + w_ * s
                a, b = f_ - size - v * mpmath.cos(phase), v * w_ * mpmath.sin(phase)
                speed = b * mpmath.cos(s) - a * mpmath.sin(s) - v * w_ * mpmath.sin(end)
                place = a * mpmath.cos(s) + b * mpmath.sin(s) + v * mpmath.cos(end) - f_
                return [speed, place - size]

            guess = tuple(mpmath.findroot(rest, guess))
        return float(friction - mpmath.cos(guess[0]))


def amplitude(w: float, f: float, *, backend: str | None = None) -> float:
    """Of the periodic motion: where it turns back."""
    map_ = map_of("f", backend=backend).holding(w=w, f=f)
    cycle = shoot(map_, [0.5 * numbers(w)[0] if f > stops_from(w) else numbers(w)[0], -0.1])
    if not cycle.success:
        raise ValueError(f"no periodic motion was found at w = {w}, f = {f}: {cycle.status.value}")
    start = {"x": cycle.x[0, 0], "u_x": cycle.x[0, 1]}
    motion = simulate(map_.system, start, 2.0 * math.pi / w, backend=backend)
    turns = [event.time for event in motion.events if event.symbol[0] in "RJ"]
    return float(max(np.abs(motion.q[np.isin(motion.t, turns), 0])))


def followed(w: float) -> Diagram:
    """The motion over the friction, through where stops begin."""
    map_, least = map_of("f").holding(w=w, f=0.6 * stops_from(w)), stops_from(w)
    cycle = shoot(map_, [numbers(w)[0], -0.1])
    return continuation(
        map_, cycle, (0.55 * least, 1.2 * least), [(-4, 4), (-4, 4)], orders=(1,)
    ).diagram


def border(found: Diagram) -> tuple[float, str]:
    """Where stops begin on that branch, and what happens there."""
    (branch,) = found.branches
    (change,) = branch.changes
    return float(branch.parameter[change.first]), change.cause


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Amplitudes over frequency and over friction, and the border between both kinds.

    Parameters
    ----------
    fast
        Fewer motions.
    out
        Folder for ``system_den_hartog.png``.

    Returns
    -------
    dict
        ``frequencies`` and ``largest_difference`` from the closed form; ``with_stops``: the
        largest one from the equations with thirty digits; ``border``: how far the friction from
        which on it stops is from the closed form.
    """
    count, f, slow = 5 if fast else 40, 0.2, 0.6
    w = np.linspace(0.55, 2.4, count) + 0.013
    w = w[[stops_from(each) > f for each in w]]
    found = np.array([amplitude(each, f) for each in w])
    exact = np.array([exact_amplitude(each, f) for each in w])
    frictions = np.linspace(stops_from(slow), 0.9, 4 if fast else 14)[1:]
    stopping = np.array([amplitude(slow, each) for each in frictions])
    known = np.array([amplitude_with_stops(slow, each) for each in frictions])
    place, _ = border(followed(slow))
    if out is not None:
        keep(draw((w, found, exact), (frictions, stopping, known), slow, place),
             out / "system_den_hartog.png")  # fmt: skip
    return {
        "frequencies": len(w), "largest_difference": float(np.abs(found - exact).max()),
        "with_stops": float(np.abs(stopping - known).max()),
        "border": abs(place - stops_from(slow)),
    }  # fmt: skip


Three = tuple[Floats, Floats, Floats]


def draw(over_w: Three, over_f: Three, slow: float, place: float) -> Figure:
    """Amplitudes over the frequency, and over the friction through the border."""
    figure, (left, right) = canvas(3.6, columns=2)
    w, found, exact = over_w
    left.plot(w, exact, color=STABLE, label="closed form")
    left.plot(w, found, "o", color=RED, mfc="none", markersize=4, label="shooting")
    left.set(xlabel="$w$", ylabel="amplitude at $f = 0.2$", yscale="log")
    f, stopping, known = over_f
    free = np.linspace(0.0, stops_from(slow), 40)
    right.plot(free, [exact_amplitude(slow, each) for each in free], color=STABLE,
               label="no stops")  # fmt: skip
    right.plot([free[-1], *f], [exact_amplitude(slow, free[-1]), *known], "--", color=STABLE,
               label="two stops")  # fmt: skip
    right.plot(f, stopping, "o", color=RED, mfc="none", markersize=4)
    right.plot(place, exact_amplitude(slow, place), "|", color="black", markersize=14,
               label="change of word")  # fmt: skip
    right.set(xlabel="$f$", ylabel=f"amplitude at $w = {slow}$")
    left.legend()
    right.legend(loc="lower left")
    return figure


if __name__ == "__main__":
    command(main, "system_den_hartog")
