"""The command ``pwmap explore``: a page in the browser for a map that is typed."""

from __future__ import annotations

import webbrowser
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from pwmap.cli.options import Given, Values
from pwmap.cli.reading import assignments
from pwmap.cli.screen import complain, option, say, told

if TYPE_CHECKING:
    from pwmap.explore.serving import Serve

Port = Annotated[
    int | None,
    option(
        "Port at 127.0.0.1; by default the first from 5007 on that is free.", least=1, most=65535
    ),
]
NoBrowser = Annotated[bool, option("Do not open a browser, only say the address.", "--no-browser")]
Stay = Annotated[bool, option("Go on when the last page was closed, until Ctrl-C.", "--stay")]
MISSING = "the explorer needs Bokeh: pip install bokeh, or the package with its extra explore"


def explore(
    formula: Annotated[
        str | None, typer.Argument(help="The map, as the text of a sympy Piecewise in x.")
    ] = None,
    set_: Values = None,
    given: Given = None,
    port: Port = None,
    no_browser: NoBrowser = False,
    stay: Stay = False,
) -> None:
    """Open the explorer: a map with sliders for its parameters, and exact answers beside it.

    By default the map is P1^L of the paper. The page is served by this machine to this machine
    only, and nothing that is typed is executed.

    Example: pwmap explore "Piecewise((a*x + 1, x <= 0), (b*x + 1, True))" --set a=1/2 --set b=-3/2
    """
    serve = opening(port, no_browser, stay)
    from pwmap.explore.map_data import completed, held
    from pwmap.explore.map_page import run
    from pwmap.explore.map_state import MapState, of_map

    with told("Interrupted: no page was opened"):
        values = assignments(set_ or ())
        state = MapState() if formula is None else of_map(formula, "", values)
        kept = tuple(sorted({**dict(state.values), **values}.items()))
        state = completed(replace(state, given="; ".join(given or (state.given,)), values=kept))
        held(state)
        state.at(values)  # raises for a name that is not a parameter
        run(state, serve)


def opening(port: int | None, no_browser: bool, stay: bool) -> Serve:
    """A function that serves a page and says its address; without Bokeh the command ends."""
    try:
        from pwmap.explore.serving import serve
    except ImportError:
        complain(f"Failed: {MISSING}")
        raise typer.Exit(1) from None

    def ready(address: str) -> None:
        say(f"The explorer is at {address} (Ctrl-C ends it)")
        if not no_browser:
            webbrowser.open(address)

    return partial(serve, port=port, stay=stay, ready=ready)
