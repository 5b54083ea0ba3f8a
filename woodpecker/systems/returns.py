"""The return map of a system: a piecewise-smooth map of R^d for the engine."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from copy import copy
from itertools import chain
from typing import Any

import numpy as np

from pwmap.algebra.arguments import explained_fields
from pwmap.diagrams.shown import brief, counted
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import instance, lengths, whole
from woodpecker.base.counting import weight
from woodpecker.base.settings import unit
from woodpecker.base.shown import shown
from woodpecker.engine.maps import SpaceImage, proposed
from woodpecker.systems.mechanics.model import ContactSystem
from woodpecker.systems.mechanics.status import MotionStatus, StoppedError
from woodpecker.systems.simulation.motion import (
    EVENTS_MOST,
    Backend,
    Run,
    assembled,
)
from woodpecker.systems.simulation.paths import SystemPiece
from woodpecker.systems.simulation.sections import Embedding, Section

OFF_SECTION = 1e-6  # scaled: states, or returns, that differ by less count as equal


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
        The k parameters that are free, as names or symbols.
    backend
        ``"heyoka"`` or ``"scipy"``; by default the first if it is installed.
    x_scale, p_scale
        Units of coordinates and parameters; by default the lengths of the window and the spans of
        a call that has them, else 1.
    events_most
        Largest number of events of one return.

    Raises
    ------
    ValueError, TypeError
        If the section does not fit the system, a parameter is unknown, without effect or named
        twice, or there are other than d and k positive scales.
    """

    def __init__(
        self, system: ContactSystem, section: Section, parameters: Sequence[Any] = (), *,
        backend: Backend | str | None = None, x_scale: Sequence[float] | None = None,
        p_scale: Sequence[float] | None = None, events_most: int = EVENTS_MOST,
    ) -> None:  # fmt: skip
        if isinstance(parameters, str) or not isinstance(parameters, Iterable):
            raise TypeError(f"parameters must be a list of names, got {shown(parameters)}")
        instance("system", system, ContactSystem)
        instance("section", section, Section)
        self.system, self.section = system, section
        self.parameters = tuple(map(str, parameters))
        if len(set(self.parameters)) < len(self.parameters):
            raise ValueError(f"parameters must differ, got {list(self.parameters)}")
        self.events_most = whole("events_most", events_most)
        self._check_used()
        self.eq = assembled(system, self.parameters, backend, section)
        self.embedding = Embedding(self.eq, section)
        self.d, self.k = self.embedding.d, len(self.parameters)
        self.x_scale = lengths("x_scale", x_scale, [1.0] * self.d)
        self.p_scale = lengths("p_scale", p_scale, [1.0] * self.k)
        self._has_scales = x_scale is not None, p_scale is not None

    def _check_used(self) -> None:
        laws = [(c.gap, c.slip, c.mu, c.eps_n) for c in self.system.contacts]
        own = self.section.when, self.section.period, *self.section.at.values()
        parts = self.system.M, self.system.h, *chain(*laws), *own
        used = set().union(*(getattr(part, "free_symbols", ()) for part in parts))
        for symbol in self.system.named(self.parameters):
            if symbol not in used:
                raise ValueError(
                    f"nothing varies with {symbol}: it occurs neither in the system nor in the "
                    "section"
                )

    def __repr__(self) -> str:
        """Its coordinates, its event, and the free parameters."""
        free, when = ", ".join(map(str, self.section.free)), brief(str(self.section.when))
        of = f"{counted(self.system.n, 'coordinate')} and {counted(self.eq.m, 'contact')}"
        over = ", ".join(f"{n}={v:.6g}" for n, v in zip(self.parameters, self.p, strict=True))
        return f"SystemMap({free} at {when!r}, of {of}{', over ' * bool(over)}{over})"

    def holding(self, **values: float) -> SystemMap:
        """The same map with other values of the system's parameters; both share compiled code.

        Raises
        ------
        ValueError
            If a parameter is unknown or a value is not finite.
        """
        other = copy(self)
        other.system = self.system.replace(**values)
        other.embedding = copy(self.embedding)
        other.embedding.own = np.array(list(other.system.parameters.values()))
        return other

    def within(
        self, window: Sequence[tuple[float, float]], spans: Sequence[tuple[float, float]] = ()
    ) -> SystemMap:
        """The same map in units of the lengths of these intervals, where it was given no scales."""
        other, (has_x, has_p) = copy(self), self._has_scales
        if not has_x:
            other.x_scale = tuple(unit(*ends) or 1.0 for ends in window)  # may be a single point
        if not has_p:
            other.p_scale = (*(unit(*ends) for ends in spans), *self.p_scale[len(spans) :])
        return other

    @property
    def p(self) -> Floats:
        """(k,) the system's own values of the free parameters."""
        return np.asarray(self.embedding.own[self.eq.places])

    @property
    def evaluations(self) -> int:
        """The number of returns that this thread has computed, by search or along a path."""
        return self.embedding.counter.evaluations

    def check_laws(self, p: Floats) -> None:
        """ValueError if masses, friction or restitution are out of range at parameters (k,)."""
        values = self.embedding.values(p).tolist()
        self.system.check_laws(dict(zip(self.system.parameters, values, strict=True)))

    def search(self, x: Floats, p: Floats) -> Run:
        """The motion from a point (d,) of the section until it returns, without derivatives."""
        values = self.embedding.values(p)
        z, _ = self.embedding.state(x, values)
        return self._run(z, values, self.embedding.obstacle(x, p))

    def _run(self, z: Floats, values: Floats, why: str = "") -> Run:
        """The motion from a state on the section until it returns; none if ``why`` says so."""
        run = Run(self.eq, z, values, self.embedding, events_most=self.events_most)
        if why:
            return run.stop(StoppedError(MotionStatus.NO_SOLUTION, why))
        if not np.isfinite(z).all():
            return run.stop(StoppedError(MotionStatus.OVERFLOW))
        try:
            run.z, touch, striking = self.embedding.begin(z, values)
        except StoppedError as stop:
            return run.stop(stop)
        run.follow(touch, striking)
        self.embedding.counter.evaluations += weight(len(run.events))
        return run

    def duration(self, x: Floats, p: Floats) -> float:
        """The time [s] of the return from a point (d,) of the section."""
        start, _ = self.embedding.state(x, self.embedding.values(p))
        return float(self.search(x, p).z[-1] - start[-1])

    def orbit(self, x: Floats, p: Floats) -> Iterator[Run]:
        """Motions from return to return, up to the first that does not return."""
        success = True
        while success:
            run = self.search(x, p)
            x, success = run.point, run.status.success
            yield run

    def taken(self, x: Floats, p: Floats) -> tuple[SystemPiece, Floats]:
        """The piece that the system takes from a point (d,), and its image; nan if it is lost.

        It is found without derivatives, which take several times as long.
        """
        run = self.search(x, p)
        if run.status.success:
            path, word = (tuple(run.legs), run.last, run.turns), " ".join(run.symbols)
            return SystemPiece(*path, word, self.embedding, np.array(run.durations)), run.point
        return SystemPiece((), None, 0, run.message, self.embedding, np.zeros(0)), run.point

    def check_section(self, x: Floats, p: Floats) -> None:
        """ValueError if the section lacks a symbol on which a return from a point (d,) depends.

        The state and time at which a motion returns may differ from the section's, as those of a
        machine that walks on, or one period later; but the next return must be the same from both.
        """
        values = self.embedding.values(p)
        run = self.search(x, p)
        if not run.status.success:
            return
        point = run.point
        there, here = run.z, self.embedding.state(point, values)[0]
        off = np.abs(there - here) / np.maximum(1.0, np.abs(there))
        if off.max() <= OFF_SECTION:
            return
        expected, again = self.search(point, p).point, self._run(run.z, values).point
        apart = np.abs(again - expected) / self.x_scale  # nan if one does not return
        if apart.max() > OFF_SECTION * max(1.0, float(np.abs(expected / self.x_scale).max())):
            moved = off[:-1].max(initial=0.0) > OFF_SECTION
            k = int(off[:-1].argmax()) if moved else -1  # time goes on anyhow
            symbol = self.system.state[k]
            raise ValueError(
                f"the motion returns with {symbol} = {there[k]:.6g}, and the section has "
                f"{here[k]:.6g}: name {symbol} in its free symbols, or what it is there in at"
            )

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """The return from a point (d,) of the section along the path that the system takes."""
        return self.taken(x, p)[0].at(x, p)

    def beside(self, x: Floats, p: Floats, direction: Floats) -> SpaceImage:
        """The return along the path that the system takes infinitesimally beside a point."""
        return proposed(self, x, p, direction, (*self.x_scale, *self.p_scale))
