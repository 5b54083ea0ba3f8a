"""Options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pwmap.cli.screen import option


def path(text: str | Path) -> Path:
    """The path that was typed; BadParameter for an empty text, as of a variable that is not set."""
    if not str(text).strip():
        raise typer.BadParameter(f"a path is expected, got {text!r}")
    return Path(text)


FILE, FOLDER = "<file>", "<folder>"  # what the help shows in place of a path
LOW_HIGH = "<low> <high>"  # and in place of the ends of an interval
Formula = Annotated[str, typer.Argument(help="The map, as the text of a sympy Piecewise.")]
Values = Annotated[
    list[str] | None, option("Value of a parameter, such as a=5/4 or a=1.25; repeatable.", "--set")
]
Orders = Annotated[str, option("Iterates to look at, such as 1,2,4 or 1-8.")]
Given = Annotated[list[str] | None, option("An assumption on the parameters, such as 'a > 1'.")]
Ends = Annotated[
    tuple[str, str] | None,
    option(
        "Two rationals, such as 0 5/2 or 0 2.5; by default all that happens.",
        metavar=LOW_HIGH,
        show_default=False,
    ),
]
Variable = Annotated[str, option("The variable of the map.")]
Out = Annotated[
    Path,
    option(
        "Folder for the results, made if missing; about_<command>.json says what made them.",
        metavar=FOLDER,
        parser=path,
    ),
]
