"""The toy of a command: from a file, from options, or the paper's."""

from __future__ import annotations

import inspect
import json
from dataclasses import asdict
from functools import cache, partial
from pathlib import Path
from typing import Annotated, Any

import typer

from pwmap.cli.options import FILE, path
from pwmap.cli.screen import option
from pwmap.diagrams.files import write_whole
from pwmap.diagrams.record import plain
from woodpecker.mechanics.toy import (
    LAW,
    ExpansionFriction,
    Toy,
    description,
    known_parameter,
    parameters,
)

TOY = "toy"  # key of the values in a file
PANEL = "Parameters of the toy"
LARGEST = 1 << 20  # bytes of a file with a toy: a record has some thousand
READ, SAVE = "toy_file", "save_toy"  # the options that read and write a toy
KEYWORD = inspect.Parameter.KEYWORD_ONLY
CONTEXT = "context"  # argument with typer's context, which knows the source of each option
UNTYPED = "DEFAULT"  # the source of an option that was not typed


def parameter_of(text: str) -> str:
    """The name of a parameter from text, such as eps-n1 for eps_n1."""
    return known_parameter(text.strip().replace("-", "_"))


@cache
def toy_options() -> tuple[inspect.Parameter, ...]:
    """Options for the files and for each field of the toy, described as in :class:`Toy`."""
    default, of_toy = Toy(), partial(option, rich_help_panel=PANEL)
    file = of_toy(
        "File with the values of a toy, of --save-toy or the about_<command>.json of results; "
        "options beside it change single values.",
        "--toy",
        metavar=FILE,
        parser=path,
    )
    save = of_toy(
        "File into which the values are written, for --toy.",
        "--save-toy",
        metavar=FILE,
        parser=path,
    )
    law = of_toy(
        "What bounds friction in the expansion of an impact at two contacts: the sum of both "
        "normal impulses, from which the paper's figures follow, or Coulomb's law at each"
    )
    kinds: dict[str, Any] = {CONTEXT: typer.Context}
    kinds |= {READ: Annotated[Path | None, file], SAVE: Annotated[Path | None, save]}
    for name in parameters():
        meaning, unit, domain = description(name)
        text = f"{meaning[0].upper()}{meaning[1:]} [{unit}]; must {domain.value}"
        kinds[name] = Annotated[float, of_toy(text)]
    kinds[LAW] = Annotated[ExpansionFriction, law]
    return tuple(
        inspect.Parameter(name, KEYWORD, default=getattr(default, name, None), annotation=kind)
        for name, kind in kinds.items()
    )


def toy_of(values: dict[str, Any]) -> Toy:
    """The toy of options, which are removed from ``values``; ValueError, or OSError for a file."""
    file, saved = values.pop(READ), values.pop(SAVE)
    fields = {name: values.pop(name) for name in (*parameters(), LAW)}
    source = values.pop(CONTEXT).get_parameter_source
    typed = {name: value for name, value in fields.items() if source(name).name != UNTYPED}
    toy = (Toy() if file is None else read_toy(file)).replace(**typed)
    if saved is not None:
        write_toy(saved, toy)
    return toy


def write_toy(path: Path, toy: Toy) -> None:
    """Write the values of a toy as JSON; infinite values become text."""
    write_whole(path, (json.dumps({TOY: plain(asdict(toy))}, indent=1) + "\n").encode())


def read_toy(path: Path) -> Toy:
    """Read a toy from a file of :func:`write_toy` or a command's record; ValueError without one."""
    try:
        values = _content(path)
        if not isinstance(values, dict):
            raise ValueError(f"{TOY!r} must be an object with values by name, got {values!r:.60}")
        unknown = sorted({*values} - {*parameters(), LAW})
        if unknown:
            raise ValueError(f"unknown parameter {unknown[0]!r}")
        return Toy(**{name: _number(value) for name, value in values.items()})
    except (ArithmeticError, RecursionError, TypeError, ValueError) as error:
        raise ValueError(
            f"{path} holds no toy, as --save-toy writes it: {' '.join(str(error).split())}"
        ) from None


def _number(value: Any) -> Any:
    """A number that is text, as infinite ones are; the toy refuses what is none."""
    try:
        return float(value) if isinstance(value, str) else value
    except ValueError:
        return value


def _content(path: Path) -> Any:
    """The entry of a toy in a file; ValueError if there is none."""
    with path.open("rb") as file:  # which may be a pipe, or have no end
        text = file.read(LARGEST)
    try:
        found = json.loads(text, object_pairs_hook=_each_once)
    except (json.JSONDecodeError, UnicodeError) as error:
        raise ValueError(f"this is no JSON: {error}") from None
    if not isinstance(found, dict) or TOY not in found:
        raise ValueError(f"an object with an entry {TOY!r} is expected, got {found!r:.60}")
    return found[TOY]


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in pairs:
        if name in found:
            raise ValueError(f"{name!r} stands twice")
        found[name] = value
    return found
