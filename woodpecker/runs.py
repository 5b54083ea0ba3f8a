"""Runs: the toy or map with its settings, the file in which a run is stored, and its diagram."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass, fields, replace
from typing import TYPE_CHECKING, Any

from pwmap.diagrams.diagram import Diagram, PointKind, PointStatus, SpecialPoint
from pwmap.diagrams.record import LEFT_OUT_KEY, plain, program
from woodpecker.base.checkpoint import MAP, START, Entry
from woodpecker.base.checks import interval
from woodpecker.base.settings import Settings, differing
from woodpecker.maps.pieces import PiecewiseMap
from woodpecker.mechanics.toy import WINDOW, Toy, limits
from woodpecker.search.checkpoint import Record, read_record, restore
from woodpecker.search.network import Network
from woodpecker.search.search import GOLDEN
from woodpecker.toy_map import checked, map_and_names

if TYPE_CHECKING:
    from pwmap import PiecewiseLinearMap

DEFAULT = Settings(window=WINDOW)
OUT_OF_DOMAIN = "end of the values that the parameter can have"
AT, SPAN = "at", "span"  # keys of a run: the toy's value of the parameter; the span asked for
TOY, NAME = "toy", "x"  # keys of a run: its toy, or the name of the coordinate of its map
ORBITS, IMAGES = 16, 4  # number of orbits that identify a map, and of images of each
WHOLE = (0.0, 1.0)  # default span of a parameter of the toy


@dataclass(frozen=True, slots=True, kw_only=True)
class Subject:
    """A toy or map over one parameter, and the settings to follow its branches."""

    source: Toy | PiecewiseMap | PiecewiseLinearMap
    map_: PiecewiseMap  # the source as a map of pieces
    parameter: str  # name of the parameter in the diagram
    x_name: str  # name of the coordinate in the diagram
    wanted: tuple[float, float]  # the span that was asked for
    settings: Settings  # with the window, and that part of the span which the parameter can have

    @property
    def about(self) -> Entry:
        """The description of this run, which the file of a run to be resumed must have."""
        of: Entry = {NAME: self.x_name}
        if isinstance(self.source, Toy):
            fixed = {n: v for n, v in asdict(self.source).items() if n != self.parameter}
            of = {TOY: {n: str(v) if v in (math.inf, -math.inf) else v for n, v in fixed.items()}}
        settings = {"settings": asdict(self.settings)}
        return {"parameter": self.parameter, SPAN: self.wanted} | of | settings

    def finished(self, found: Diagram) -> Diagram:
        """A diagram with what was given, and ends at limits of a toy's parameter marked as such."""
        toy = self.source
        if not isinstance(toy, Toy):
            return found
        made: Entry = plain({
            "program": program(), SPAN: self.wanted, TOY: self.about[TOY],
            "settings": differing(self.settings, DEFAULT),  # only those that are not the defaults
        })  # fmt: skip
        reasons = dict(_domain_ends(toy, self.parameter, self.wanted))
        points = tuple(_of_domain(point, reasons, self.settings) for point in found.points)
        if LEFT_OUT_KEY in found.about:
            made[LEFT_OUT_KEY] = found.about[LEFT_OUT_KEY]
        return replace(found, points=points, given=given(toy, self.parameter), about=made)


def subject(
    source: Toy | PiecewiseMap | PiecewiseLinearMap, parameter: str | None,
    span: tuple[float, float] | None, settings: Settings | None,
    window: tuple[float, float] | None = None,
) -> Subject:  # fmt: skip
    """The subject of a run; span and window are by default those of the settings.

    ValueError if the span holds no value that the parameter can have; TypeError if the source is
    neither a toy nor a map, the parameter is unknown, or the settings are of another type.
    """
    map_, name, x_name = map_and_names(source, parameter)
    of_toy = isinstance(source, Toy)
    chosen = settings_for(settings, DEFAULT if of_toy else Settings())
    if window is not None:
        chosen = replace(chosen, window=window)
    usual = WHOLE if of_toy else chosen.span
    wanted = interval("span", usual if span is None else span, finite=True)
    can = possible(source, name, wanted) if isinstance(source, Toy) else wanted
    for end in can:
        checked(source, end)
    return Subject(
        source=source, map_=map_, parameter=name, x_name=x_name, wanted=wanted,
        settings=replace(chosen, span=can),
    )  # fmt: skip


def settings_for(settings: Settings | None, default: Settings, **taken: Any) -> Settings:
    """Settings, or the default, with some fields replaced; TypeError if they are not settings."""
    if not isinstance(settings, Settings | None):
        raise TypeError(
            f"settings must be woodpecker.Settings, got {type(settings).__module__}."
            f"{type(settings).__name__}"
        )
    return replace(default if settings is None else settings, **taken)


def possible(toy: Toy, parameter: str, span: tuple[float, float]) -> tuple[float, float]:
    """The part of a span whose values a parameter of the toy can have; ValueError if none."""
    low, high = limits(toy, parameter)
    if not max(span[0], low) < min(span[1], high):
        raise ValueError(f"span must hold values of {parameter} in ({low}, {high}), got {span}")
    return max(span[0], low), min(span[1], high)


def given(toy: Toy, parameter: str) -> tuple[str, str]:
    """The law of impact and the source of derivatives in the parameter, for the diagram."""
    law = str(toy.expansion_friction)
    return f"friction in the expansion: {law}", f"derivatives in {parameter}: the variational flow"


def saved_diagram(run: str | os.PathLike[str]) -> Diagram:
    """The diagram of the branches that a run has finished so far.

    Parameters
    ----------
    run
        The file that was given as ``run``.

    Returns
    -------
    Diagram
        Without branches that are not finished.

    Raises
    ------
    ValueError
        If the file is not that of such a run, or has unknown settings.

    Examples
    --------
    >>> from woodpecker import Toy, continuation, saved_diagram, shoot
    >>> toy = Toy()
    >>> diagram = continuation(toy, shoot(toy, -0.53), span=(0.45, 0.55), run="run.jsonl")
    >>> len(saved_diagram("run.jsonl").branches)
    1
    """
    run_of, entries = read_record(run)
    if unknown := unknown_settings(run_of):
        raise ValueError(
            f"{run}, line 1: expected settings of this version, got {', '.join(unknown)} too"
        )
    try:
        parameter, settings = run_of["parameter"], settings_of(run_of["settings"])
        wanted = interval("span", run_of[SPAN], finite=True)
        x_name = run_of[NAME] if TOY not in run_of else "phi_s"
        toy = _toy_of(run_of, parameter) if TOY in run_of else None
    except (KeyError, TypeError, AttributeError, ValueError):
        raise ValueError(
            f"{run}, line 1: expected a run of the toy or of a map, got one of {sorted(run_of)}"
        ) from None
    network = Network(settings)
    restore(network, entries, run)
    found = network.diagram(parameter, [x_name])
    if toy is None:
        return found
    map_, *_ = map_and_names(toy, parameter)
    return Subject(
        source=toy, map_=map_, parameter=parameter, x_name=x_name, wanted=wanted, settings=settings
    ).finished(found)


def _toy_of(run_of: Entry, parameter: str) -> Toy:
    """The toy of a run, with its own value of the parameter if the run has stored one."""
    values: Entry = {n: math.inf if v == "inf" else v for n, v in run_of[TOY].items()}
    toy = Toy(**values)
    return toy.replace(**{parameter: run_of.get(AT, getattr(toy, parameter))})


def _domain_ends(
    toy: Toy, parameter: str, wanted: tuple[float, float]
) -> Iterator[tuple[float, str]]:
    """The limits of a parameter that a span exceeds, each with the toy's sentence on why."""
    for end, possible_end in zip(wanted, limits(toy, parameter), strict=True):
        try:
            toy.replace(**{parameter: end})
        except ValueError as error:
            yield possible_end, str(error)


def _of_domain(point: SpecialPoint, reasons: dict[float, str], settings: Settings) -> SpecialPoint:
    """A point; if it ends a branch at a limit of the parameter, with the reason of that limit."""
    for end, reason in reasons.items():
        away = abs(point.parameter - end)
        if point.kind is PointKind.EP and away <= settings.same * settings.p_scale:
            return replace(
                point, note=OUT_OF_DOMAIN, cause=reason, status=PointStatus.LOCATED, precision=away,
                interval=(point.parameter - away, point.parameter + away),
            )  # fmt: skip
    return point


def orbits_of(subject: Subject, start: Sequence[float] = ()) -> dict[str, list[float | str]]:
    """Short orbits in the window, or about the start, which identify a map as it has no name."""
    (low, high), unit = subject.settings.window, subject.settings.x_scale
    if start:
        low, high = max(low, min(start) - unit), min(high, max(start) + unit)
    first, last = subject.settings.span
    orbits = {}
    for k in range(ORBITS):
        x = low + (high - low) * (k * GOLDEN % 1.0)
        p = first + (last - first) * (k + 0.5) / ORBITS
        orbits[f"the orbit at {p}, in the unit of x,"] = [*_orbit(subject, x, p)]
    return orbits


def _orbit(subject: Subject, x: float, p: float) -> Iterator[float | str]:
    """A point and a few images, in the unit of x, until they leave the window; a reason if none."""
    low, high = subject.settings.window
    yield x / subject.settings.x_scale
    for _ in range(IMAGES):
        if not low <= x <= high:
            return
        image = subject.map_.at(x, p)
        x = float(image.value)
        yield x / subject.settings.x_scale if math.isfinite(x) else image.reason


def unknown_settings(run_of: Entry) -> list[str]:
    """The names of settings in a file that do not exist here, as it is of another version."""
    kept = run_of.get("settings")
    known = {each.name for each in fields(Settings)}
    return [name for name in kept if name not in known] if isinstance(kept, dict) else []


def settings_of(kept: Entry) -> Settings:
    """The settings that are stored in a file."""
    values: Entry = {n: tuple(v) if isinstance(v, list) else v for n, v in kept.items()}
    return Settings(**values)


def nothing(_: object) -> None:
    """Ignore progress."""


@contextmanager
def recorded(
    run: str | os.PathLike[str] | None, run_of: Entry, resume: bool, subject: Subject
) -> Iterator[Record | None]:
    """The record of a run, closed at the end of the block; None without a file."""
    if run is None:
        if resume:
            raise ValueError("resuming needs the file of a run")
        yield None
        return
    if not isinstance(subject.source, Toy):
        run_of |= {MAP: orbits_of(subject, run_of.get(START, ()))}
    with closing(Record(run, run_of, resume=resume)) as record:
        yield record
