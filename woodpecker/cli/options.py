"""Common to the commands of ``woodpecker``: options, the toy, and errors."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from dataclasses import asdict
from typing import Annotated, Any, get_args, get_type_hints

from rich.markup import escape

import woodpecker  # lazy: heavy modules are loaded only after help and refusals
from pwmap.cli.interrupts import AT_ONCE
from pwmap.cli.options import LOW_HIGH
from pwmap.cli.options import Out as Out
from pwmap.cli.results import asked
from pwmap.cli.screen import number, option, take_formats, told
from woodpecker.base.lost import WorkerLostError
from woodpecker.cli.toys import toy_of, toy_options
from woodpecker.mechanics.toy import Toy

GUESS = -0.53  # rad, near the stable cycle of the paper's data set
OUT = "out"  # the option that is not recorded with the results


class CommandError(Exception):
    """A computation has no result; the message is for the user."""


def ends(text: str) -> Any:
    """An option that takes the two ends of an interval, in two words."""
    return option(text, metavar=LOW_HIGH)


Start = Annotated[
    float | None,
    option("Start at rest on the section, phi_S [rad]; by default on the periodic motion."),
]
Near = Annotated[float, option("Where the periodic motion is looked for [rad].")]
Window = Annotated[tuple[float, float], ends("Interval of phi_S [rad].")]


def with_toy(command: Callable[..., None], named: str) -> Callable[..., None]:
    """Wrap a command whose first argument is a toy: add an option for each field of the toy.

    Errors become sentences, and results are recorded under the name of the command.
    """
    hints = get_type_hints(command, include_extras=True)
    own = [
        parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY, annotation=hints[parameter.name])
        for parameter in list(inspect.signature(command).parameters.values())[1:]
    ]
    of_toy = toy_options()
    for parameter in (*own, *of_toy):
        if float in _types_in(parameter.annotation):
            parameter.annotation.__metadata__[0].parser = number

    def wrapped(**values: Any) -> None:
        with told(AT_ONCE, CommandError, WorkerLostError):
            toy = toy_of(values)
            options = {name: value for name, value in values.items() if name != OUT}
            asked.set((named, {"toy": asdict(toy), "options": options}))
            take_formats(values.get("picture") or values.get("format_"))
            command(toy, **values)

    wrapped.__signature__ = inspect.Signature([*own, *of_toy])  # type: ignore[attr-defined]
    wrapped.__annotations__ = {each.name: each.annotation for each in [*own, *of_toy]}
    wrapped.__doc__, wrapped.__name__ = escape(inspect.getdoc(command) or ""), command.__name__
    return wrapped


def _types_in(hint: Any) -> Iterator[Any]:
    for each in get_args(hint):
        yield each
        yield from _types_in(each)


def motion(toy: Toy, guess: float, order: int = 1) -> woodpecker.PeriodicOrbit:
    """The periodic motion near a guess [rad]; CommandError if there is none."""
    orbit = woodpecker.shoot(toy, guess, order)
    if not orbit.success:
        raise CommandError(f"no periodic motion near phi_S = {guess}: {orbit.message}")
    return orbit
