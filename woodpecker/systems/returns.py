"""The return map of a system: a piecewise-smooth map of R^d for the engine."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from copy import copy
from dataclasses import dataclass, field

import numpy as np

from pwmap.algebra.arguments import explained_fields
from pwmap.diagrams.shown import brief, counted
from woodpecker.base.arrays import Floats, Ints
from woodpecker.base.checks import instance, lengths, whole
from woodpecker.base.settings import unit
from woodpecker.engine.maps import SpaceImage, proposed
from woodpecker.systems.mechanics.model import ContactSystem
from woodpecker.systems.mechanics.status import MotionStatus, StoppedError
from woodpecker.systems.simulation.causes import cause_of
from woodpecker.systems.simulation.motion import (
    EVENTS_MOST,
    Backend,
    Run,
    assembled,
)
from woodpecker.systems.simulation.paths import TOO_FAR, Following, MotionPath
from woodpecker.systems.simulation.sections import Embedding, Section

OFF_SECTION = 1e-6  # scaled: states and returns that differ by less are one


@explained_fields
class SystemMap:
    """The return map of a system on a section, with derivatives in some parameters.

    Parameters
    ----------
    system
        The system; its own values of the free parameters do not matter.
    section
        The section, of dimension d.
    parameters
        Names of the k parameters that are free.
    backend
        ``"heyoka"`` or ``"scipy"``; by default the first if it is installed.
    x_scale, p_scale
        Lengths of coordinates and parameters that count as 1; by default those of the window and
        the spans of a call that has them, else 1.
    events_most
        Events of one return at most.

    Raises
    ------
    ValueError, TypeError
        If the section is none of the system, a parameter is unknown or there twice, or there are
        other than d and k positive scales.
    """

    def __init__(
        self, system: ContactSystem, section: Section, parameters: Sequence[str] = (), *,
        backend: Backend | str | None = None, x_scale: Sequence[float] | None = None,
        p_scale: Sequence[float] | None = None, events_most: int = EVENTS_MOST,
    ) -> None:  # fmt: skip
        if isinstance(parameters, str):
            raise TypeError(f"parameters must be a list of names, got {parameters!r}")
        instance("system", system, ContactSystem)
        instance("section", section, Section)
        self.system, self.section, self.parameters = system, section, tuple(parameters)
        if len(set(self.parameters)) < len(self.parameters):
            raise ValueError(f"parameters must differ, got {list(self.parameters)}")
        self.events_most = whole("events_most", events_most)
        self.eq = assembled(system, self.parameters, backend)
        self.embedding = Embedding(self.eq, section)
        self.d, self.k = self.embedding.d, len(self.parameters)
        self.x_scale = lengths("x_scale", x_scale, self.d)
        self.p_scale = lengths("p_scale", p_scale, self.k)
        self._has_scales = x_scale is not None, p_scale is not None
        self.names = self.embedding.names
        self._own = self.eq.p

    def __repr__(self) -> str:
        """Its coordinates, the event, and what is free of the system."""
        free, when = ", ".join(map(str, self.section.free)), brief(str(self.section.when))
        of = f"{counted(self.system.n, 'coordinate')} and {counted(len(self.names), 'contact')}"
        over = ", ".join(f"{n}={v:.6g}" for n, v in zip(self.parameters, self.p, strict=True))
        return f"SystemMap({free} at {when!r}, of {of}{', over ' * bool(over)}{over})"

    def holding(self, **values: float) -> SystemMap:
        """The same map with other values of the system's parameters; it shares what is compiled.

        Raises
        ------
        ValueError
            If a parameter is unknown or a value is not finite.
        """
        other = copy(self)
        other.system = self.system.replace(**values)
        other._own = np.array(list(other.system.parameters.values()))
        return other

    def within(
        self, window: Sequence[tuple[float, float]], spans: Sequence[tuple[float, float]] = ()
    ) -> SystemMap:
        """The same map; lengths of these intervals count as 1 where it was given no scales."""
        other, (has_x, has_p) = copy(self), self._has_scales
        if not has_x:
            other.x_scale = tuple(unit(*ends) or 1.0 for ends in window)  # points may be one
        if not has_p:
            other.p_scale = (*(unit(*ends) for ends in spans), *self.p_scale[len(spans) :])
        return other

    @property
    def p(self) -> Floats:
        """(k,) the system's own values of the free parameters."""
        return np.asarray(self._own[self.eq.places])

    def values(self, p: Floats) -> Floats:
        """All parameters, with those of the map in their places."""
        found = self._own.copy()
        found[self.eq.places] = p
        return found

    def check_laws(self, p: Floats) -> None:
        """ValueError if a friction or restitution is out of range at free parameters (k,)."""
        values = dict(zip(self.system.parameters, self.values(p).tolist(), strict=True))
        for each in self.system.contacts:
            each.check_laws(values)

    def obstacle(self, x: Floats, p: Floats) -> str:
        """Why friction or restitution is none at free parameters (k,); empty if they are."""
        values = self.values(p)
        terms = self.eq.terms(self.embedding.state(x, values)[0], values)
        for name, mu, eps in zip(self.names, terms.mu.tolist(), terms.eps.tolist(), strict=True):
            if mu < 0.0:
                return f"mu of {name!r} must be >= 0, got {mu:.12g}"
            if eps < 0.0 or eps > 1.0:
                return f"eps_n of {name!r} must be in [0, 1], got {eps:.12g}"
        return ""

    def search(self, x: Floats, p: Floats) -> Run:
        """The motion from a point (d,) of the section until it returns."""
        values = self.values(p)
        z, tangents = self.embedding.state(x, values)
        return self._run(z, tangents, values)

    def _run(self, z: Floats, tangents: Floats, values: Floats) -> Run:
        """The motion from a state on the section, with its derivatives, until it returns."""
        run = Run(self.eq, z, values, self.embedding, events_most=self.events_most)
        if not np.isfinite(z).all():
            return run.stop(StoppedError(MotionStatus.OVERFLOW))
        try:
            run.z, touch, striking = self.embedding.begin(z, tangents, values)
        except StoppedError as stop:
            return run.stop(stop)
        return run.follow(touch, striking)

    def taken(self, x: Floats, p: Floats) -> tuple[MotionPath, Floats]:
        """The path that the system takes from a point (d,), and where it returns; nan if nowhere.

        Without derivatives, which take several times as long.
        """
        path, value, _ = self._met(x, p)
        return path, value

    def _met(self, x: Floats, p: Floats) -> tuple[MotionPath, Floats, Floats]:
        """The same, and the durations of phases; there are none if it does not return."""
        why = self.obstacle(x, p)
        run = None if why else self.search(x, p)
        if run is None or not run.status.success:
            path = MotionPath((), None, 0, why if run is None else run.message)
            return path, np.full(self.d, np.nan), np.zeros(0)
        turns = self.embedding.turns(run.z, self.values(p))
        path = MotionPath(tuple(run.legs), run.last, turns, " ".join(run.symbols))
        return path, self.landed(run, p), np.array(run.durations)

    def image(self, x: Floats, p: Floats) -> Floats | None:
        """Where a point (d,) of the section returns, without derivatives; None if it does not."""
        path, value = self.taken(x, p)
        return value if path.legs else None

    def landed(self, run: Run, p: Floats) -> Floats:
        """The point (d,) of the section at which a motion has returned."""
        values = self.values(p)
        return self.embedding.point(run.z, values, self.embedding.turns(run.z, values))

    def check_section(self, x: Floats, p: Floats) -> None:
        """ValueError if the section leaves out what matters for a motion from a point (d,).

        A state that returns may differ from the section's, as a machine walks on; but the next
        return must be the same from both.
        """
        values = self.values(p)
        z, tangents = self.embedding.state(x, values)
        run = self._run(z, tangents, values)
        if not run.status.success:
            return
        point = self.landed(run, p)
        there, here = run.z[:-1], self.embedding.state(point, values)[0][:-1]  # time may go on
        off = np.abs(there - here) / np.maximum(1.0, np.abs(there))
        expected = self.image(point, p) if off.max() > OFF_SECTION else None
        again = self._run(run.z, tangents, values) if expected is not None else None
        if expected is None or again is None or not again.status.success:
            return
        apart = np.abs(self.landed(again, p) - expected) / self.x_scale
        if apart.max() > OFF_SECTION * max(1.0, float(np.abs(expected / self.x_scale).max())):
            k = int(off.argmax())
            symbol = self.system.state[k]
            raise ValueError(
                f"the motion returns with {symbol} = {there[k]:.6g}, and the section has "
                f"{here[k]:.6g}: name {symbol} in its free symbols, or what it is there in at"
            )

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """The return from a point (d,) of the section along the path that the system takes."""
        path, _, times = self._met(x, p)
        return SystemPiece(self, path, times).at(x, p)

    def beside(self, x: Floats, p: Floats, direction: Floats) -> SpaceImage:
        """The return along the path that the system takes infinitesimally beside a point."""
        return proposed(self, x, p, direction, (*self.x_scale, *self.p_scale))


@dataclass(frozen=True, slots=True, eq=False)
class SystemPiece:
    """Returns along one path."""

    whole: SystemMap  # the map that it belongs to
    path: MotionPath  # what happens
    times: Floats = field(repr=False)  # durations of its phases where it was met last

    @property
    def key(self) -> Hashable:
        """The same for two pieces just if they are one."""
        return self.path

    @property
    def word(self) -> str:
        """The sequence of events."""
        return self.path.word

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """The return along this path, also where the system takes another one."""
        if not self.path.legs:
            return self.undefined(self.path.word)
        whole = self.whole
        obstacle = whole.obstacle(x, p)
        if obstacle:
            return self.undefined(obstacle)
        following = Following(whole.embedding, self.path, whole.values(p))
        try:
            found, times = following.follow(np.asarray(x, dtype=float), self.times)
        except (StoppedError, np.linalg.LinAlgError):
            return self.undefined(TOO_FAR)
        _, jacobian, *_ = found
        if not np.isfinite(jacobian).all():
            return self.undefined(TOO_FAR)
        return SpaceImage(*found, SystemPiece(whole, self.path, times))

    def undefined(self, reason: str) -> SpaceImage:
        """An image without a value."""
        d, columns = self.whole.d, self.whole.d + self.whole.k
        none: Ints = np.zeros(0, dtype=np.int64)
        return SpaceImage(
            np.full(d, np.nan), np.full((d, columns), np.nan), np.zeros(0), np.zeros((0, columns)),
            none, self, reason,
        )  # fmt: skip

    def cause(self, code: int) -> str:
        """A sentence on what happens where a margin vanishes."""
        return cause_of(self.path.legs, code, self.whole.names)
