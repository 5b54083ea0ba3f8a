"""The command ``woodpecker``: simulate, map, diagram, curves, prove, check and more."""

from __future__ import annotations

import logging

import matplotlib as mpl
import typer

from woodpecker.cli.curves import curves
from woodpecker.cli.diagram import diagram
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
):
    app.command(name=name)(with_toy(command))
app.command(name="check")(check)


@app.callback()
def _without_screen() -> None:
    """Draw into files only, before any command loads what draws."""
    mpl.use("Agg")


def run() -> None:
    """Entry point of the command."""
    logging.basicConfig(format="%(message)s")
    app()
