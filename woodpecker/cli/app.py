"""The command ``woodpecker``: simulate, map, diagram, curves, prove, check and more."""

from __future__ import annotations

from pwmap.cli.screen import command_line, prepare
from woodpecker.cli.curves import curves
from woodpecker.cli.diagram import diagram
from woodpecker.cli.explore import explore
from woodpecker.cli.maps import draw_map
from woodpecker.cli.motion import animate, simulate
from woodpecker.cli.options import with_toy
from woodpecker.cli.prove import check, prove
from woodpecker.cli.regions import regions
from woodpecker.cli.robustness import robustness

app = command_line(
    "woodpecker", "The Woodpecker Toy: exact simulation, return map, bifurcation diagram."
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
prepare(app)
