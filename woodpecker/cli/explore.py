"""The command ``woodpecker explore``: a page in the browser where everything moves."""

from __future__ import annotations

import webbrowser
from typing import Annotated

import typer

from pwmap.cli_screen import say
from woodpecker.cli.help import option
from woodpecker.cli.options import CommandError
from woodpecker.mechanics.toy import Toy

Port = Annotated[
    int | None,
    option("Port at 127.0.0.1; by default the first from 5007 on that is free.", min=1, max=65535),
]
NoBrowser = Annotated[bool, option("Do not open a browser, only say the address.", "--no-browser")]
Stay = Annotated[bool, option("Go on when the last page was closed, until Ctrl-C.", "--stay")]
MISSING = 'the explorer needs Bokeh: pip install "woodpecker-toy[explore]"'


def explore(toy: Toy, port: Port = None, no_browser: NoBrowser = False, stay: Stay = False) -> None:
    """Open the explorer: return map, branches, motion and word of the toy under sliders.

    The page is served by this machine to this machine only. It ends with Ctrl-C, or when its last
    page was closed.

    Example: woodpecker explore --eps-n1 0.3
    """
    try:
        import bokeh  # noqa: F401
    except ImportError:
        raise CommandError(MISSING) from None
    from dataclasses import replace

    from woodpecker.explore.app import run
    from woodpecker.explore.state import State

    def ready(address: str) -> None:
        say(f"The explorer is at {address} (Ctrl-C ends it)")
        if not no_browser:
            webbrowser.open(address)

    run(replace(State(), toy=toy), port, stay=stay, ready=ready)
    raise typer.Exit
