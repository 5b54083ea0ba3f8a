"""The command ``woodpecker``: simulate, map, diagram, curves, prove, check and more."""

from __future__ import annotations

import logging
import os
from typing import Annotated

import typer

from pwmap.cli.screen import in_paragraphs, say
from woodpecker.cli.curves import curves
from woodpecker.cli.diagram import diagram
from woodpecker.cli.explore import explore
from woodpecker.cli.interrupts import listen
from woodpecker.cli.maps import draw_map
from woodpecker.cli.motion import animate, simulate
from woodpecker.cli.options import with_toy
from woodpecker.cli.prove import check, prove
from woodpecker.cli.regions import regions
from woodpecker.cli.robustness import robustness

app = typer.Typer(
    help="The Woodpecker Toy: exact simulation, return map, bifurcation diagram.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)
for name, command in (
    ("simulate", simulate),
    ("animate", animate),
    ("map", draw_map),
    ("diagram", diagram),
    ("curves", curves),
    ("regions", regions),
    ("robustness", robustness),
    ("prove", prove),
    ("explore", explore),
):
    app.command(name=name)(with_toy(command, name))
app.command(name="check")(check)
in_paragraphs(app)


def _tell_version(asked: bool) -> None:
    if asked:
        from woodpecker import __version__

        say(f"woodpecker {__version__}")
        raise typer.Exit


@app.callback()
def _before(
    _: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version and leave.", callback=_tell_version, is_eager=True
        ),
    ] = False,
) -> None:
    """The Woodpecker Toy: exact simulation, return map, bifurcation diagram."""
    os.environ["MPLBACKEND"] = "Agg"  # draw into files only, said before matplotlib is loaded


def run() -> None:
    """Entry point of the command."""
    logging.basicConfig(format="%(message)s")
    listen()
    app()
