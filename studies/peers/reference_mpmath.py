"""The toy's return map to thirty digits and more: slow, plain, independent of `woodpecker`.

It is written from the equations of motion alone. For given index sets the linear system
M qdd = h + W lambda together with the constraints of the closed contacts [Eq. 1, 3] gives the
accelerations and contact forces as affine functions of the spring stretch d = phi_S - phi_M; the
motion is summed as a Taylor series in mpmath, so every guard is a polynomial on a step and its
first zero can be isolated rigorously. Contact problems, in an impact and on acceleration level,
are solved by trying every combination of index sets; if none or several hold, the run ends with a
sentence that says so.

`expansion_friction` chooses the bound of friction in the expansion of an impact at two contacts 1
and k: "summed" |Lambda_Ti| <= mu_i (Lambda_N1 + Lambda_Nk), from which the paper's figures follow,
or "separate" |Lambda_Ti| <= mu_i Lambda_Ni. Everywhere else it is Coulomb's law contact by contact.

    python -m studies.peers.reference_mpmath PHI_S [EPS_N1 [summed|separate]]
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from itertools import product

from mpmath import inf, mp, mpf, nan, nstr

Toy = dict[str, float | str]

PAPER: Toy = {
    "m_m": 0.0003, "j_m": 5.0e-9, "m_s": 0.0045, "j_s": 7.0e-7, "g": 9.81,
    "r_0": 0.0025, "r_m": 0.0031, "h_m": 0.0058, "l_m": 0.010, "l_g": 0.015,
    "h_s": 0.020, "l_s": 0.0201, "c_phi": 0.0056,
    "mu_1": 0.3, "mu_2": 0.3, "mu_3": 0.3, "eps_n1": 0.5, "eps_n2": 0.0, "eps_n3": 0.0,
    "expansion_friction": "summed",
}  # fmt: skip

STEP = 5e-4  # length of a Taylor step [s]; the free oscillation turns by 0.23 rad in it
QUIET = 5.0  # a mode that lasts longer than this [s] without an event is given up
GUARD_DIGITS = 25  # working digits beyond those asked for

Vector = list[mpf]
Series = list[mpf]  # Taylor coefficients in s = (t - t_0) / step


class Lost(Exception):  # noqa: N818  (the end of a motion, not a mistake)
    """The motion cannot be continued to the section; the message says why."""


class Touch(Enum):
    """What one contact does during a smooth phase."""

    OPEN = "gap open"
    STICK = "closed and sticking"
    UP = "closed, slip velocity positive"
    DOWN = "closed, slip velocity negative"

    @property
    def slip(self) -> int:
        """Sign of the slip velocity; 0 if it does not slide."""
        return {Touch.UP: 1, Touch.DOWN: -1}.get(self, 0)


Mode = tuple[Touch, Touch, Touch]
FREE: Mode = (Touch.OPEN,) * 3


class Kind(Enum):
    """What a guard watches; it is positive as long as the mode is right."""

    GAP = "gap of an open contact"
    FORCE = "normal force of a closed contact"
    CONE = "distance of a sticking contact to its friction bound"
    SLIP = "slip velocity of a sliding contact, times its sign"
    TURN = "phi_S', times its sign, while contact 2 sticks"


@dataclass(frozen=True)
class Return:
    """One return to the section; `phi_s` is nan unless `status` is "returned"."""

    phi_s: mpf
    period: mpf
    drop: mpf
    word: str
    times: tuple[mpf, ...]
    status: str


def dot(a: Sequence[mpf], b: Sequence[mpf]) -> mpf:
    """Scalar product."""
    return sum((x * y for x, y in zip(a, b, strict=True)), mpf(0))


def solve(matrix: Sequence[Sequence[mpf]], *rhs: Sequence[mpf]) -> list[Vector]:
    """Solve the square system for each right-hand side; pivoting, ZeroDivisionError if singular."""
    n = len(matrix)
    rows = [[*row, *(b[i] for b in rhs)] for i, row in enumerate(matrix)]
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(rows[i][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(n):
            if i != k and rows[i][k]:
                factor = rows[i][k]
                rows[i] = [x - factor * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [[row[n + j] for row in rows] for j in range(len(rhs))]


def shifted(c: Series, s: mpf) -> Series:
    """Taylor coefficients of the same polynomial about s; its value there comes first."""
    c, out = list(c), []
    while c:
        for k in range(len(c) - 2, -1, -1):
            c[k] += s * c[k + 1]
        out.append(c.pop(0))
    return out


def value(c: Series, s: mpf) -> mpf:
    """Sum of the series at s."""
    out = mpf(0)
    for a in reversed(c):
        out = out * s + a
    return out


def derivative(c: Series) -> Series:
    """Coefficients of the derivative with respect to s."""
    return [k * a for k, a in enumerate(c)][1:]


def first_exit(c: Series, width: mpf) -> mpf | None:
    """First s in [0, width] where the polynomial, positive at 0, falls through zero.

    Halves the interval until the coefficients prove on each part that there is no zero, or that
    slope or curvature keep their sign, so no pair of zeros is missed. A dip below zero by no more
    than rounding is a touch, not an exit.
    """
    if not c or c[0] <= 0:
        return mpf(0) if c else None
    if len(c) < 3:
        c = [*c, mpf(0), mpf(0)]
    size = [abs(a) * width**k for k, a in enumerate(c)]
    if size[0] > sum(size[1:], mpf(0)):
        return None
    bent = 2 * size[2] > sum((k * (k - 1) * a for k, a in enumerate(size[3:], 3)), mpf(0))
    end = width
    if bent and c[2] > 0 > c[1]:  # convex: up to its minimum it falls
        rise = [-a for a in derivative(c)]
        if value(rise, width) < 0:
            end = crossing(rise, width)
            if value(c, end) > -max(size) * mpf(10) ** (8 - mp.dps):
                return None
    if bent or size[1] > sum((k * a for k, a in enumerate(size[2:], 2)), mpf(0)):
        return crossing(c, end) if value(c, end) <= 0 else None
    half = width / 2
    if half < mp.eps:
        return None
    found = first_exit(c, half)
    if found is not None:
        return found
    found = first_exit(shifted(c, half), half)
    return None if found is None else half + found


def crossing(c: Series, width: mpf) -> mpf:
    """The one zero of a polynomial that is > 0 at 0 and <= 0 at width (Newton, bracketed)."""
    slope = derivative(c)
    low, high, s = mpf(0), width, mpf(0)
    for _ in range(10 * mp.dps):
        p, dp = value(c, s), value(slope, s)
        low, high = (s, high) if p > 0 else (low, s)
        new = s - p / dp if dp < 0 else high + 1
        if not low <= new <= high:
            new = (low + high) / 2
        if abs(new - s) <= new * mpf(10) ** (4 - mp.dps):
            return new
        s = new
    return s


@dataclass(frozen=True)
class Motion:
    """qdd = a + b d, and lambda = const + slope * d at each contact, for one mode."""

    a: Vector
    b: Vector
    normal: list[tuple[mpf, mpf]]
    tangential: list[tuple[mpf, mpf]]
    terms: int  # length of the Taylor series that this mode needs


@dataclass
class Model:
    """The toy's matrices, and the tolerance below which a quantity counts as zero."""

    p: dict[str, mpf]
    step: mpf
    summed: bool  # friction in the expansion at two contacts
    zero: mpf  # relative to the natural scale of the quantity
    motions: dict[Mode, Motion] = field(default_factory=dict)

    def __post_init__(self) -> None:
        p = self.p
        m_m, m_s, l_m, l_g, c = p["m_m"], p["m_s"], p["l_m"], p["l_g"], p["c_phi"]
        self.mass = [
            [m_s + m_m, m_s * l_m, m_s * l_g],
            [m_s * l_m, p["j_m"] + m_s * l_m**2, m_s * l_m * l_g],
            [m_s * l_g, m_s * l_m * l_g, p["j_s"] + m_s * l_g**2],
        ]
        self.h_0 = [-p["g"] * row for row in self.mass[0]]
        self.h_1 = [mpf(0), c, -c]
        zero, one = mpf(0), mpf(1)
        self.w_n = [[zero, zero, -p["h_s"]], [zero, p["h_m"], zero], [zero, -p["h_m"], zero]]
        self.w_t = [[one, l_m, l_g - p["l_s"]], [one, p["r_m"], zero], [one, p["r_m"], zero]]
        play = p["r_m"] - p["r_0"]
        self.gap_0 = [l_m + l_g - p["l_s"] - p["r_0"], play, play]
        self.mu = [p["mu_1"], p["mu_2"], p["mu_3"]]
        self.eps_n = [p["eps_n1"], p["eps_n2"], p["eps_n3"]]
        weight = p["g"] * self.mass[0][0]
        self.unit = {Kind.GAP: play, Kind.FORCE: weight, Kind.CONE: weight, Kind.TURN: one,
                     Kind.SLIP: play / self.step}  # fmt: skip
        self.ladder = [self.step**2 / ((k + 1) * (k + 2)) for k in range(200)]

    def motion(self, mode: Mode) -> Motion:
        """Solve M qdd - W lambda = h with the constraints of the closed contacts [Eq. 1, 3]."""
        if mode not in self.motions:
            self.motions[mode] = self._solve_mode(mode)
        return self.motions[mode]

    def _solve_mode(self, mode: Mode) -> Motion:
        columns: list[Vector] = []
        constraints: list[Vector] = []
        place: dict[int, int] = {}
        for i, touch in enumerate(mode):
            if touch is Touch.OPEN:
                continue
            place[i] = 3 + len(columns)
            slide = touch.slip * self.mu[i]  # lambda_T = -slip mu lambda_N
            columns.append([n - slide * t for n, t in zip(self.w_n[i], self.w_t[i], strict=True)])
            constraints.append(self.w_n[i])
            if touch is Touch.STICK:
                columns.append(self.w_t[i])
                constraints.append(self.w_t[i])
        none = [mpf(0)] * len(columns)
        matrix = [self.mass[j] + [-w[j] for w in columns] for j in range(3)]
        matrix += [w + none for w in constraints]
        x_0, x_1 = solve(matrix, self.h_0 + none, self.h_1 + none)
        normal, tangential = [(mpf(0), mpf(0))] * 3, [(mpf(0), mpf(0))] * 3
        for i, k in place.items():
            normal[i] = (x_0[k], x_1[k])
            slide = mode[i].slip * self.mu[i]
            tangential[i] = (-slide * x_0[k], -slide * x_1[k])
            if mode[i] is Touch.STICK:
                tangential[i] = (x_0[k + 1], x_1[k + 1])
        reach, term, n = abs(x_1[2] - x_1[1]) * self.step**2, mpf(1), 3
        while n < 6 or term > mpf(10) ** -mp.dps:
            term, n = term * reach / ((n + 1) * (n + 2)), n + 2
        return Motion(x_0[:3], x_1[:3], normal, tangential, n)

    def series(self, mode: Mode, q: Vector, u: Vector) -> list[Series]:
        """Taylor coefficients of q over one step, in the mode."""
        motion = self.motion(mode)
        c = [[x, v * self.step] for x, v in zip(q, u, strict=True)]
        for k in range(motion.terms - 2):
            pull = (c[2][k] - c[1][k]) * self.ladder[k]
            for i in range(3):
                push = motion.a[i] * self.ladder[0] if k == 0 else 0
                c[i].append(motion.b[i] * pull + push)
        return c

    def guards(self, mode: Mode, c: list[Series]) -> list[Guard]:
        """Every quantity that must stay positive in the mode."""
        motion = self.motion(mode)
        d = [s - m for s, m in zip(c[2], c[1], strict=True)]

        def affine(pair: tuple[mpf, mpf]) -> Series:
            return [pair[0] + pair[1] * d[0]] + [pair[1] * x for x in d[1:]]

        out = []
        for i, touch in enumerate(mode):
            if touch is Touch.OPEN:
                k = 2 if i == 0 else 1
                gap = [self.w_n[i][k] * x for x in c[k]]
                gap[0] += self.gap_0[i]
                out.append(Guard(Kind.GAP, i, gap))
                continue
            (n_0, n_1), (t_0, t_1), mu = motion.normal[i], motion.tangential[i], self.mu[i]
            out.append(Guard(Kind.FORCE, i, affine((n_0, n_1))))
            if touch is Touch.STICK:
                for s in (1, -1):
                    bound = affine((mu * n_0 + s * t_0, mu * n_1 + s * t_1))
                    out.append(Guard(Kind.CONE, i, bound))
            else:
                w = [touch.slip * x / self.step for x in self.w_t[i]]
                path = [dot(w, x) for x in zip(*c, strict=True)]
                out.append(Guard(Kind.SLIP, i, derivative(path)))
        return out


@dataclass(frozen=True)
class Guard:
    """A function of time whose first fall through zero ends a mode."""

    kind: Kind
    contact: int
    c: Series


def lead(model: Model, guard: Guard, known: Mapping[int, int]) -> Guard:
    """Divide out the power of s with which the guard starts: the first non-zero derivative rules.

    `known` tells, for each contact at gap zero, whether its gap starts like s (1) or flatter (2).
    """
    order, small = 0, model.zero * model.unit[guard.kind]
    if guard.kind is Kind.GAP:
        order = known.get(guard.contact, 0)
        if order < 2:
            return Guard(guard.kind, guard.contact, guard.c[order:])
    while order < len(guard.c) and abs(guard.c[order]) < small:
        order += 1
    return Guard(guard.kind, guard.contact, guard.c[order:])


def bounds(model: Model, contacts: Sequence[int], normal: Sequence[mpf], summed: bool) -> Vector:
    """Largest friction at each contact for these normal forces."""
    if summed:
        normal = [sum(normal, mpf(0))] * len(contacts)
    return [model.mu[i] * n for i, n in zip(contacts, normal, strict=True)]


def sticking_pair(
    model: Model,
    pair: Sequence[int],
    load: Vector,
    floor: Sequence[mpf],
    small: mpf,
    summed: bool = False,
) -> list[Vector] | None:
    """Two contacts that both stick: the sleeve and the bird are at rest, W Lambda = load.

    Four forces, three equations: the admissible ones form a segment. Its two ends, as normal
    forces, or None if it is empty.
    """
    i, j = pair
    matrix = list(zip(model.w_n[i], model.w_n[j], model.w_t[j], strict=True))
    base, minus = solve(matrix, load, model.w_t[i])  # forces = base - minus * lambda_Ti
    conditions = [(base[0] - floor[0], -minus[0]), (base[1] - floor[1], -minus[1])]
    most, less = (bounds(model, pair, x[:2], summed) for x in (base, minus))
    for s in (1, -1):
        conditions.append((most[0], s - less[0]))
        conditions.append((most[1] + s * base[2], -less[1] - s * minus[2]))
    low, high = -inf, inf
    for const, slope in conditions:  # const + slope * lambda_Ti >= 0
        if slope > 0:
            low = max(low, -const / slope)
        elif slope < 0:
            high = min(high, -const / slope)
        elif const < -small:
            return None
    if low > high + small:
        return None
    return [[base[k] - minus[k] * end for k in (0, 1)] for end in (low, high)]


def impact_phase(
    model: Model,
    hit: Sequence[int],
    u: Vector,
    floor: Sequence[mpf],
    small: mpf,
    summed: bool = False,
) -> tuple[Vector, list[Vector]]:
    """One phase of an impact: 0 <= gdot_N perp (Lambda_N - floor) >= 0 with friction.

    Friction is judged by the tangential velocity at the end of the phase, and bounded contact by
    contact or by the sum of the normal impulses. Returns the velocity and the normal impulses
    (both ends of the segment where they are not unique).
    """
    w = [x for i in hit for x in (model.w_n[i], model.w_t[i])]
    m_w = solve(model.mass, *w)
    delassus = [[dot(x, y) for y in m_w] for x in w]
    v = [dot(x, u) for x in w]
    small_force = small * model.mass[0][0]
    found: list[tuple[Vector, list[Vector]]] = []
    states = list(product((True, False), (0, 1, -1)))  # normally closed; slip direction
    for choice in product(states, repeat=len(hit)):
        if choice == ((True, 0),) * 2:
            load = [-dot(row, u) for row in model.mass]
            ends = sticking_pair(model, hit, load, floor, small_force, summed)
            found += [([mpf(0)] * 3, ends)] if ends else []
            continue
        matrix: list[Vector] = []
        rhs: Vector = []
        for k, (closed, slip) in enumerate(choice):
            normal, tangential = 2 * k, 2 * k + 1
            unit = [mpf(j == normal) for j in range(len(w))]
            matrix.append(delassus[normal] if closed else unit)
            rhs.append(-v[normal] if closed else floor[k])
            slide = slip * model.mu[hit[k]]
            bound = [slide * (j % 2 == 0 and (summed or j == normal)) for j in range(len(w))]
            bound[tangential] = mpf(1)  # Lambda_T + slip times the bound = 0
            matrix.append(bound if slip else delassus[tangential])
            rhs.append(mpf(0) if slip else -v[tangential])
        try:
            (impulse,) = solve(matrix, rhs)
        except ZeroDivisionError:
            continue
        after = [x + dot(row, impulse) for x, row in zip(v, delassus, strict=True)]
        fits, most = True, bounds(model, hit, impulse[::2], summed)
        for k, (_, slip) in enumerate(choice):
            (n, t), (v_n, v_t) = impulse[2 * k : 2 * k + 2], after[2 * k : 2 * k + 2]
            fits &= n - floor[k] >= -small_force and v_n >= -small
            fits &= abs(t) <= most[k] + small_force  # without a bound any slip will do
            fits &= slip * v_t >= -small or most[k] <= small_force
        if fits:
            kick = [dot(impulse, x) for x in zip(*m_w, strict=True)]
            found.append(([x + y for x, y in zip(u, kick, strict=True)], [impulse[::2]] * 2))
    if not found:
        raise Lost(f"impact at {names(hit)}: no solution")
    reach = [mpf(1), model.p["h_m"], model.p["h_s"]]
    for other, _ in found[1:]:
        moved = [abs(x - y) * r for x, y, r in zip(found[0][0], other, reach, strict=True)]
        if max(moved) > 1000 * small:
            raise Lost(f"impact at {names(hit)}: several solutions")
    return found[0]


def impact(model: Model, hit: Sequence[int], u: Vector) -> tuple[Vector, list[int]]:
    """Poisson's two phases. Returns u after the impact and the contacts left with gdot_N = 0."""
    small = model.zero * max(abs(dot(model.w_n[i], u)) for i in hit)
    none = [mpf(0)] * len(hit)
    u, (lambda_n, other) = impact_phase(model, hit, u, none, small)
    floor = [model.eps_n[i] * max(x, mpf(0)) for i, x in zip(hit, lambda_n, strict=True)]
    spread = [model.eps_n[i] * (x - y) for i, x, y in zip(hit, lambda_n, other, strict=True)]
    if max(abs(x) for x in spread) > small * model.mass[0][0]:
        raise Lost(f"impact at {names(hit)}: the impulses of compression are not unique")
    u, _ = impact_phase(model, hit, u, floor, small, model.summed)
    resting = [i for i in hit if abs(dot(model.w_n[i], u)) <= 1000 * small]
    return halted(u, resting), resting


def halted(u: Vector, contacts: Sequence[int]) -> Vector:
    """The velocity with gdot_N of these contacts exactly zero."""
    held = {2 if i == 0 else 1 for i in contacts}
    return [mpf(0) if k in held else x for k, x in enumerate(u)]


def decide(
    model: Model, q: Vector, u: Vector, resting: Sequence[int], known: Mapping[int, int]
) -> Mode:
    """Acceleration level: the one mode whose guards all start positive, for the resting contacts.

    On a boundary the first non-zero derivative of the guard decides.
    """
    options = []
    for i in resting:
        slip = dot(model.w_t[i], u)
        if abs(slip) < model.zero * model.unit[Kind.SLIP]:
            options.append([Touch.STICK, Touch.UP, Touch.DOWN, Touch.OPEN])
        else:
            options.append([Touch.UP if slip > 0 else Touch.DOWN, Touch.OPEN])
    found: list[tuple[Mode, list[Series]]] = []
    for choice in product(*options):
        touch = dict(zip(resting, choice, strict=True))
        mode = (touch.get(0, FREE[0]), touch.get(1, FREE[1]), touch.get(2, FREE[2]))
        if choice == (Touch.STICK,) * 2:
            load = [-x - y * (q[2] - q[1]) for x, y in zip(model.h_0, model.h_1, strict=True)]
            small = model.zero * model.unit[Kind.FORCE]
            if sticking_pair(model, resting, load, [mpf(0)] * 2, small):
                found.append((mode, [[x, mpf(0), mpf(0)] for x in q]))
            continue
        try:
            c = model.series(mode, q, u)
        except ZeroDivisionError:
            continue
        leads = [lead(model, g, known) for g in model.guards(mode, c)]
        if all(g.c[0] > 0 if g.c else g.kind is not Kind.SLIP for g in leads):
            found.append((mode, c))
    if not found:
        raise Lost(f"contacts {names(resting)}: no acceleration fits")
    (mode, first), *others = found
    for _, c in others:
        differ = [abs(x[2] - y[2]) for x, y in zip(first, c, strict=True)]
        if max(differ) > model.zero * model.ladder[0]:
            raise Lost(f"contacts {names(resting)}: several accelerations fit")
    if mode.count(Touch.STICK) == 2:
        raise Lost(f"at rest on contacts {names(resting)}")
    return mode


def names(contacts: Sequence[int]) -> str:
    """Numbers of contacts as in a word."""
    return "+".join(str(i + 1) for i in sorted(contacts))


def changes(
    before: Mode, after: Mode, resting: Sequence[int], struck: Sequence[int], quiet: Sequence[int]
) -> list[str]:
    """Symbols D, J, S, R of one event, by ascending contact; none for the quiet contacts."""
    out = []
    for i, (was, now) in enumerate(zip(before, after, strict=True)):
        if now is Touch.OPEN:
            symbol = "D" if was is not Touch.OPEN or i in resting else ""
        elif now is Touch.STICK:
            symbol = "J" if was is not Touch.STICK else ""
        elif was is Touch.STICK:
            symbol = "S"
        else:
            symbol = "R" if was.slip == -now.slip and not struck else ""
        if symbol and i not in quiet:
            out.append(f"{symbol}{i + 1}")
    return out


@dataclass
class Run:
    """A motion under way: state, mode, and the word so far."""

    model: Model
    q: Vector
    u: Vector
    mode: Mode
    t: mpf = field(default_factory=mpf)
    word: list[str] = field(default_factory=list)
    times: list[mpf] = field(default_factory=list)
    known: dict[int, int] = field(default_factory=dict)  # contacts at gap zero, see `lead`
    fresh: bool = True  # no step taken since the last event
    rising: bool = False
    last: tuple[mpf, mpf] = (mpf(0), mpf(0))  # time and speed of the latest impact

    def step(self) -> bool:
        """Advance to the first event in the next Taylor step, or to its end; True on a return."""
        model = self.model
        c = model.series(self.mode, self.q, self.u)
        guards = model.guards(self.mode, c)
        if self.mode[1] is Touch.STICK:
            guards.append(Guard(Kind.TURN, 1, derivative(c[2])))
        if self.fresh:
            guards = [lead(model, g, self.known) for g in guards]
            if guards[-1].kind is Kind.TURN and guards[-1].c:
                self.rising = guards[-1].c[0] > 0
        exits = []
        for g in guards:
            flip = g.kind is Kind.TURN and not self.rising
            s = first_exit([-x for x in g.c] if flip else g.c, mpf(1))
            if s is not None:
                exits.append((s, g))
        s = min((x for x, _ in exits), default=mpf(1))
        self.q = [value(x, s) for x in c]
        self.u = [value(derivative(x), s) / model.step for x in c]
        self.t += s * model.step
        self.fresh = bool(exits)
        fired = [g for x, g in exits if x <= s + model.zero]
        if fired and all(g.kind is Kind.TURN for g in fired):
            self.known = {i: 2 for i in range(3) if self.mode[i] is not Touch.OPEN}
            return not self.rising
        if fired:
            self.settle([g.contact for g in fired if g.kind is Kind.GAP])
        return False

    def settle(self, struck: Sequence[int]) -> None:
        """Impact, if gaps closed, then the contact problem on acceleration level and the word."""
        resting = [i for i in range(3) if self.mode[i] is not Touch.OPEN]
        hit = sorted({*struck, *resting})
        symbols: list[str] = []
        if struck:
            speed = max(abs(dot(self.model.w_n[i], self.u)) for i in struck)
            symbols = [f"I{names(hit)}"]
            still = self.still()
            if len(still) > 1:
                struck = hit = resting = still
                symbols, self.u = [f"C{names(still)}"], halted(self.u, still)
            elif self.accumulates(symbols, speed):
                symbols, resting = [f"C{names(struck)}"], hit
                self.u = halted(self.u, hit)
            else:
                self.last = (self.t, speed)
                self.u, resting = impact(self.model, hit, self.u)
        self.known = {i: 2 if i in resting else 1 for i in hit}
        before, self.mode = self.mode, FREE
        self.mode = decide(self.model, self.q, self.u, resting, self.known)
        closed_now = struck if symbols[:1] == [f"C{names(struck)}"] else ()
        symbols += changes(before, self.mode, resting, struck, closed_now)
        self.word += symbols
        self.times += [self.t] * len(symbols)

    def still(self) -> list[int]:
        """The beak and a contact of the sleeve, if impacts in turns have all but stopped both."""
        slow = mpf(10) ** ((10 - mp.dps) / 2)  # [m/s]; a gap follows from it as its square
        found = []
        for i, w in enumerate(self.model.w_n):
            if self.mode[i] is not Touch.OPEN:  # what bounces on a closed contact is a series
                continue
            gap, speed = self.model.gap_0[i] + dot(w, self.q), dot(w, self.u)
            if abs(gap) < slow * slow and abs(speed) < slow:
                found.append(i)
        return found if 0 in found else []

    def accumulates(self, symbols: list[str], speed: mpf) -> bool:
        """Whether these impacts only repeat the last one, too weak to matter: chatter.

        If so, sum the time of all further bounces and take the run of impacts off the word.
        """
        t_last, speed_last = self.last
        negligible = mpf(10) ** (GUARD_DIGITS - mp.dps)  # [m/s]
        if self.word[-1:] != symbols or not speed < min(speed_last, negligible):
            return False
        ratio = speed / speed_last
        self.t += (self.t - t_last) * ratio / (1 - ratio)
        while self.word[-1:] == symbols:
            self.word.pop()
            self.times.pop()
        return True


def first_return(
    phi_s: float,
    toy: Toy = PAPER,
    digits: int = 30,
    max_events: int = 400,
    step: float = STEP,
) -> Return:
    """Follow the toy from phi_S on the section to the next minimum of phi_S while it jams.

    Every number of `toy` and `phi_s` stands for the exact value of its double. The Taylor step [s]
    is there to test convergence with; results do not depend on it.
    """
    law = toy.get("expansion_friction", "summed")
    if law not in ("summed", "separate"):
        raise ValueError(f"expansion_friction must be 'summed' or 'separate', got {law!r}")
    with mp.workdps(digits + GUARD_DIGITS):
        model = Model(
            p={name: mpf(x) for name, x in toy.items() if name != "expansion_friction"},
            step=mpf(step),
            summed=law == "summed",
            zero=mpf(10) ** (-mpf(2 * digits) / 3),
        )
        q = [mpf(0), -model.gap_0[1] / model.p["h_m"], mpf(phi_s)]
        if dot(model.w_n[0], q) + model.gap_0[0] <= 0:
            raise ValueError(f"phi_s must leave the beak off the pole, got {phi_s}")
        run = Run(model, q, [mpf(0)] * 3, (Touch.OPEN, Touch.STICK, Touch.OPEN))
        steps, events, status = 0, 0, "returned"
        try:
            run.settle([])
            while not run.step():
                steps = 0 if run.fresh else steps + 1
                events += run.fresh
                if steps * model.step > QUIET:
                    raise Lost(f"no event for {QUIET} s")
                if events > max_events:
                    raise Lost(f"no return within {max_events} events")
        except Lost as lost:
            status = str(lost)
        image = run.q[2] if status == "returned" else nan
        return Return(image, run.t, -run.q[0], " ".join(run.word), tuple(run.times), status)


def main(arguments: Sequence[str]) -> None:
    """Print one return to thirty digits."""
    toy = PAPER | ({"eps_n1": float(arguments[1])} if len(arguments) > 1 else {})
    toy |= {"expansion_friction": arguments[2]} if len(arguments) > 2 else {}
    result = first_return(float(arguments[0]), toy)
    lines = [
        f"status  {result.status}",
        f"phi_s   {nstr(result.phi_s, 30)}",
        f"period  {nstr(result.period, 30)} s",
        f"drop    {nstr(result.drop, 30)} m",
        f"word    {result.word}",
    ]
    for symbol, t in zip(result.word.split(), result.times, strict=True):
        lines.append(f"{symbol:>6}  {nstr(t, 30)} s")
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
