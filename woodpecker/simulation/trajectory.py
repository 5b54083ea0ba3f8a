"""Simulations of the toy: the exact solution, its events, and its energy balance."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from pwmap.algebra.arguments import explained, explained_fields
from pwmap.diagrams.frames import DataFrame, dataframe
from pwmap.diagrams.shown import brief, counted, table
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import instance, number, positive, real_array, whole
from woodpecker.base.compiled import announce
from woodpecker.mechanics.equations import (
    energy,
    mass_matrix,
    normal_directions,
    tangential_directions,
)
from woodpecker.mechanics.modes import (
    LAMBDA,
    OMEGA,
    SLIP_NEGATIVE,
    SLIP_POSITIVE,
    STICK,
    mode_states,
    model,
)
from woodpecker.mechanics.toy import Toy
from woodpecker.motion.codes import EVENT_COLUMNS, NO_PATH, PHASE_COLUMNS
from woodpecker.motion.flow import flow, sample
from woodpecker.simulation.calls import compute, run
from woodpecker.simulation.status import Status, status
from woodpecker.simulation.words import IMPACTS, EventKind, decode, symbol, word

MAX_EVENTS = 20_000  # events of one simulation unless the caller says otherwise
SAMPLES = 1001  # evenly spaced samples of a trajectory unless the caller says otherwise
COORDINATES, VELOCITIES = ("y", "phi_m", "phi_s"), ("dy", "dphi_m", "dphi_s")
PIECES_MOST = 100_000  # of a sliding phase, over each of which its work is integrated
COUNTED_MOST = 10**6  # samples, or events, of one simulation
GAUSS_POINTS = 24  # per half radian of a swing: the error of the quadrature is below rounding


@explained_fields
@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """A state of the toy: angles [rad], displacement [m] and velocities [rad/s, m/s].

    Examples
    --------
    >>> from woodpecker import Toy, State, simulate
    >>> toy = Toy()
    >>> State.on_section(toy, -0.53)
    State(phi_m=-0.10344827586206895, phi_s=-0.53, y=0.0, dy=0.0, dphi_m=0.0, dphi_s=0.0)
    >>> motion = simulate(toy, State(phi_m=0.0, phi_s=-0.2), t_end=0.05)  # let go of in the air
    >>> motion.events[0].symbol
    'I2s'
    """

    phi_m: float
    phi_s: float
    y: float = 0.0
    dy: float = 0.0
    dphi_m: float = 0.0
    dphi_s: float = 0.0

    def __post_init__(self) -> None:
        for name in self.__slots__:
            object.__setattr__(self, name, number(name, getattr(self, name)))

    @classmethod
    def on_section(cls, toy: Toy, phi_s: float) -> State:
        """The state at rest on the lower contact of the sleeve of ``toy``, at ``phi_s`` [rad]."""
        instance("toy", toy, Toy)
        return cls(phi_m=-toy.phi_m_max, phi_s=phi_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class Impulse:
    """Impulses [N s] at one contact, normal and tangential, in compression and expansion.

    Examples
    --------
    >>> from woodpecker import Toy, simulate
    >>> beak = simulate(Toy(), -0.53, t_end=0.1).events[4].impulses[0]
    >>> beak.contact, round(beak.normal_expansion / beak.normal_compression, 12)  # eps_N1
    (1, 0.5)
    """

    contact: int
    normal_compression: float
    tangential_compression: float
    normal_expansion: float
    tangential_expansion: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """One event of a motion.

    Velocities are (dy [m/s], dphi_M [rad/s], dphi_S [rad/s]); they differ only at impacts.

    Examples
    --------
    >>> from woodpecker import Toy, simulate
    >>> event = simulate(Toy(), -0.53, t_end=0.1).events[2]
    >>> event.symbol, event.contacts, round(event.time, 9)
    ('I3', (3,), 0.045077325)
    """

    symbol: str
    kind: EventKind
    contacts: tuple[int, ...]
    time: float
    u_before: tuple[float, float, float]
    u_after: tuple[float, float, float]
    impulses: tuple[Impulse, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trajectory:
    """An exact solution of the toy.

    Parameters
    ----------
    toy
        The toy.
    t, q, u
        Samples: times (n,), coordinates (n, 3) and velocities (n, 3). Event times occur twice,
        with the velocities before and after.
    events, word
        The events, in order of time, then of cause and effect; their symbols.
    status, t_end
        Why the motion ended, and when [s].
    drop
        Distance fallen [m]; infinite if the toy falls for ever.

    Examples
    --------
    >>> from woodpecker import Toy, simulate
    >>> motion = simulate(Toy(), -0.53, t_end=0.15)
    >>> q, u = motion.at(0.05)  # exact at any time
    >>> q.round(9).tolist()  # y, phi_M, phi_S
    [-0.002904165, 0.103448276, 0.107294589]
    """

    toy: Toy
    t: Floats
    q: Floats
    u: Floats
    events: tuple[Event, ...]
    word: str
    status: Status
    t_end: float
    drop: float
    phases: Floats = field(repr=False)

    def at(self, t: npt.ArrayLike, *, left: bool = False) -> tuple[Floats, Floats]:
        """Exact (y, phi_M, phi_S) [m, rad] and velocities [m/s, rad/s], each of shape (..., 3).

        ``t`` are times [s] of any shape; at an event velocities are those after it, or before it if
        ``left``. ValueError for times that lie outside [0, t_end] or are no real numbers.
        """
        times = real_array("t", t)
        flat = np.ascontiguousarray(times.ravel())
        if not np.all((flat >= 0.0) & (flat <= self.t_end)):
            outside = flat[~((flat >= 0.0) & (flat <= self.t_end))][0]
            raise ValueError(f"t must lie in [0, {self.t_end:.9g}], got {outside}")
        out = np.empty((flat.size, 7))
        sample(model(self.toy), self.phases, flat, left, out)
        shape = (*times.shape, 3)
        return out[:, :3].reshape(shape), out[:, 3:6].reshape(shape)

    def __repr__(self) -> str:
        return (
            f"Trajectory(t_end={self.t_end:.6g}, drop={self.drop:.6g}, "
            f"{counted(len(self.t), 'sample')}, {counted(len(self.events), 'event')} "
            f"{brief(self.word)!r}, {self.status.value!r})"
        )

    def _repr_html_(self) -> str:
        rows = [
            (f"{event.time:.9f}", event.symbol, event.kind.name.lower()) for event in self.events
        ]
        return table(repr(self), ("t [s]", "event", "what"), rows)

    def to_dataframe(self) -> DataFrame:
        """The samples, one in each row, as a pandas.DataFrame; ImportError without pandas.

        Columns are ``t`` [s], ``y`` [m], ``phi_m``, ``phi_s`` [rad], ``dy`` [m/s], ``dphi_m`` and
        ``dphi_s`` [rad/s]. Event times occur twice, before and after the event.
        """
        columns = zip((*COORDINATES, *VELOCITIES), (*self.q.T, *self.u.T), strict=True)
        return dataframe({"t": self.t, **dict(columns)})

    def events_to_dataframe(self) -> DataFrame:
        """The events, one in each row, as a pandas.DataFrame; ImportError without pandas.

        Columns are ``t`` [s], ``event`` (its symbol), ``what`` (its kind), ``contacts`` (such as
        ``"1+3"``), and the velocities ``dy_before`` [m/s] to ``dphi_s_after`` [rad/s].
        """
        events = self.events
        speeds = np.array([(*e.u_before, *e.u_after) for e in events]).reshape(-1, 6)
        names = [f"{name}_{side}" for side in ("before", "after") for name in VELOCITIES]
        return dataframe(
            {
                "t": np.array([event.time for event in events], dtype=float),
                "event": [event.symbol for event in events],
                "what": [event.kind.name.lower().replace("_", " ") for event in events],
                "contacts": ["+".join(map(str, event.contacts)) for event in events],
                **dict(zip(names, speeds.T, strict=True)),
            }
        )


@explained("a toy has its own values, toy.replace(...) others")
def simulate(
    toy: Toy,
    start: float | State,
    t_end: float,
    *,
    samples: int = SAMPLES,
    max_events: int = MAX_EVENTS,
) -> Trajectory:
    """Follow the toy until ``t_end`` [s].

    Parameters
    ----------
    toy
        The toy.
    start
        Angle phi_S [rad] of a start at rest on the section, or any :class:`State`.
    t_end
        Final time [s], positive and finite.
    samples
        Number of evenly spaced samples, at least 2, to which the event times are added.
    max_events
        Largest number of events, at least 1.

    Returns
    -------
    Trajectory
        It ends before ``t_end``, with a status, where the toy falls off the pole or the contact
        laws leave open what follows.

    Raises
    ------
    TypeError, ValueError
        If an argument is of another type or out of range, or the start penetrates a contact.

    Examples
    --------
    >>> from woodpecker import Toy, simulate
    >>> motion = simulate(Toy(), -0.53, t_end=0.15)
    >>> motion.word
    'S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2'
    >>> print(f"the beak strikes after {1e3 * motion.events[4].time:.6f} ms")
    the beak strikes after 48.187190 ms
    """
    instance("toy", toy, Toy)
    t_end = positive("t_end", t_end)
    samples = whole("samples", samples, 2, COUNTED_MOST)
    max_events = whole("max_events", max_events, most=COUNTED_MOST)
    state = start if isinstance(start, State) else State.on_section(toy, number("phi_s", start))
    return _followed(toy, state, t_end, samples, max_events)


def _followed(toy: Toy, state: State, t_end: float, samples: int, max_events: int) -> Trajectory:
    numbers = model(toy)
    z, states = _initial(toy, state)
    start = z.copy()
    codes, counts = np.zeros(max_events, dtype=np.int16), np.zeros(3, dtype=np.int64)
    phases = np.zeros((max_events + 1, PHASE_COLUMNS))
    rows = np.zeros((max_events, EVENT_COLUMNS))
    announce(compute)
    reason = status(run(numbers, z, states, False, t_end, codes, phases, NO_PATH, rows, counts))
    phases = phases[: max(1, counts[1])].copy()
    if counts[1] == 0:  # the contact problem at the start decides no mode
        phases[0, :7] = z[:] = start
    finish, drop = float(z[6]), float(state.y - z[0])
    if -z[0] > toy.pole:
        reason = Status.POLE_END
        finish, drop = _pole_end(toy, numbers, phases, finish), toy.pole + state.y
    phases.setflags(write=False)
    events = tuple(_event(row) for row in rows[: counts[2]])
    times, before = _sample_times(finish, samples, events)
    out = np.empty((len(times), 7))
    sample(numbers, phases, times, False, out)
    sample(numbers, phases, times[before], True, left := np.empty((before.sum(), 7)))
    out[before] = left
    return Trajectory(
        toy=toy, t=times, q=out[:, :3].copy(), u=out[:, 3:6].copy(), events=events,
        word=word(codes[: min(counts[0], max_events)].tolist()), status=reason, t_end=finish,
        drop=drop, phases=phases,
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class EnergyBalance:
    """Energies and losses [J] of a motion; their relative ``residual`` is zero up to rounding.

    Examples
    --------
    >>> from woodpecker import Toy, simulate
    >>> from woodpecker.simulation import energy_balance
    >>> balance = energy_balance(simulate(Toy(), -0.53, t_end=0.1))
    >>> abs(balance.residual) < 1e-12 * balance.largest
    True
    """

    initial: float
    final: float
    friction: float
    impacts: float
    largest: float

    @property
    def residual(self) -> float:
        """Initial - final - losses, relative to the largest energy that was exchanged."""
        return (self.initial - self.final - self.friction - self.impacts) / self.largest


def energy_balance(trajectory: Trajectory) -> EnergyBalance:
    """Energies of a motion, and its losses, which are computed from forces and impulses alone.

    The power lambda_T g_T of sliding friction is integrated by Gauss quadrature; a phase of an
    impact does the work Lambda (g_before + g_after) / 2.

    Parameters
    ----------
    trajectory
        The motion.

    Returns
    -------
    EnergyBalance
        Energies [J], and the residual.

    Raises
    ------
    TypeError, ValueError
        If ``trajectory`` is none, an energy overflows, or the spring swings too often while a
        contact slides.

    Examples
    --------
    >>> from woodpecker import Toy, simulate
    >>> from woodpecker.simulation import energy_balance
    >>> balance = energy_balance(simulate(Toy(), -0.53, t_end=0.1))
    >>> f"{1e6 * balance.friction:.4f} {1e6 * balance.impacts:.4f}"  # micro-joule, lost
    '83.2612 125.1273'
    """
    instance("trajectory", trajectory, Trajectory)
    toy, end = trajectory.toy, trajectory.t_end
    q, u = trajectory.at(np.array([0.0, end]))
    kinetic, potential = energy(toy, q, u)
    initial, final = (kinetic + potential).tolist()
    friction = -_sliding_work(trajectory)
    impacts = -sum(_impact_work(toy, event) for event in trajectory.events)
    peak = max(float(energy(toy, trajectory.q, trajectory.u)[0].max()), abs(initial - final))
    return EnergyBalance(
        initial=initial, final=final, friction=friction, impacts=impacts, largest=peak or 1.0
    )


def _initial(toy: Toy, state: State) -> tuple[Floats, npt.NDArray[np.int64]]:
    """State (7,) and contact states (3,) for the kernel, which decides contacts at rest anew."""
    values = (state.y, state.phi_m, state.phi_s, state.dy, state.dphi_m, state.dphi_s, 0.0)
    z = np.array(values, dtype=float)
    if not np.isfinite(z).all():
        raise ValueError(f"a state must be finite, got {state}")
    gaps = (toy.phi_s_max - z[2], toy.phi_m_max + z[1], toy.phi_m_max - z[1])
    for contact, gap in enumerate(gaps, start=1):
        if gap < 0.0:
            raise ValueError(
                f"the start penetrates contact {contact}: its angle is {-gap:.3g} rad too far"
            )
    rates = (-z[5], z[4], -z[4])
    states = np.zeros(3, dtype=np.int64)
    for i in range(3):
        if gaps[i] == 0.0 and rates[i] == 0.0:
            slip = float(np.dot(tangential_directions(toy)[i], z[3:6]))
            states[i] = (STICK, SLIP_POSITIVE, SLIP_NEGATIVE)[int(np.sign(slip))]  # the last: -1
    return z, states


def _pole_end(toy: Toy, numbers: Floats, phases: Floats, finish: float) -> float:
    """Time at which y passes the end of the pole, by bisection in the last phase."""
    low, high = float(phases[-1, 6]), finish
    out = np.empty((1, 7))
    while low < (middle := 0.5 * (low + high)) < high:
        sample(numbers, phases, np.array([middle]), False, out)
        if -out[0, 0] > toy.pole:
            high = middle
        else:
            low = middle
    return low


def _sample_times(
    finish: float, samples: int, events: tuple[Event, ...]
) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """Times of samples, ascending, and which of them mean the instant before an event."""
    grid = np.linspace(0.0, finish, samples)
    instants = np.array(sorted({event.time for event in events if 0.0 < event.time <= finish}))
    times = np.concatenate([np.setdiff1d(grid, instants), instants, instants])
    before = np.zeros(len(times), dtype=bool)
    before[len(times) - 2 * len(instants) : len(times) - len(instants)] = True
    order = np.lexsort((~before, times))
    return times[order], before[order]


def _event(row: Floats) -> Event:
    kind, contacts = decode(int(row[1]))
    compression, expansion = row[8:].reshape(2, 2, 2).tolist()  # (N, T) of beak and sleeve
    impulses = tuple(
        Impulse(
            contact=i, normal_compression=c[0], tangential_compression=c[1],
            normal_expansion=e[0], tangential_expansion=e[1],
        )
        for i in (contacts if kind in IMPACTS else ())
        for c, e in [(compression[i > 1], expansion[i > 1])]
    )  # fmt: skip
    before, after = row[2:5].tolist(), row[5:8].tolist()
    return Event(
        symbol=symbol(int(row[1])), kind=kind, contacts=contacts, time=float(row[0]),
        u_before=tuple(before), u_after=tuple(after), impulses=impulses,
    )  # fmt: skip


def _sliding_work(trajectory: Trajectory) -> float:
    """Integral of lambda_T g_T over all sliding phases [J], negative."""
    numbers, toy = model(trajectory.toy), trajectory.toy
    directions: Floats = np.array(tangential_directions(toy))
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    starts = trajectory.phases[:, 6]
    ends = np.append(starts[1:], trajectory.t_end)
    total = 0.0
    for phase, start, end in zip(trajectory.phases, starts, ends, strict=True):
        mode = int(phase[7])
        sliding = [i for i, s in enumerate(mode_states(mode)) if s > STICK]
        if not sliding or end <= start:
            continue
        swung = 2.0 * numbers[mode, OMEGA] * (end - start)
        if not swung < PIECES_MOST:
            raise ValueError(
                f"the energy balance follows at most {PIECES_MOST} half radians of a swing while a "
                f"contact slides, got {swung:.3g}"
            )
        pieces = 1 + int(swung)
        edges = np.linspace(0.0, end - start, pieces + 1)
        half = 0.5 * np.diff(edges)[:, None]
        times = (edges[:-1, None] + half * (1.0 + nodes)).ravel()
        out = np.empty((times.size, 7))
        for k, t in enumerate(times):
            flow(numbers, mode, phase[:7], t, out[k])
        d = out[:, 2] - out[:, 1]
        for i in sliding:
            p, r = numbers[mode, LAMBDA + 4 * i + 2 : LAMBDA + 4 * i + 4]
            power = (p + r * d) * (out[:, 3:6] @ directions[i])
            total += float(np.sum(power.reshape(pieces, -1) * weights * half))
    return total


def _impact_work(toy: Toy, event: Event) -> float:
    """Work of the impulses of an impact [J], negative, summed over its phases."""
    if not event.impulses:
        return 0.0
    mass: Floats = np.array(mass_matrix(toy))
    normal: Floats = np.array(normal_directions(toy))
    tangent: Floats = np.array(tangential_directions(toy))
    u, work = np.array(event.u_before), 0.0
    for phase in ("compression", "expansion"):
        impulse = sum(
            getattr(p, f"normal_{phase}") * normal[p.contact - 1]
            + getattr(p, f"tangential_{phase}") * tangent[p.contact - 1]
            for p in event.impulses
        )
        after = u + np.linalg.solve(mass, impulse)
        work += float(impulse @ (u + after)) / 2.0
        u = after
    return work
