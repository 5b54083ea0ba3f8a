"""The command ``woodpecker explore``: an interactive page in the browser."""

from __future__ import annotations

from typing import Annotated

import typer

from pwmap.cli.explore import NoBrowser, Port, Stay, opening
from woodpecker.mechanics.toy import Toy


def explore(
    toy: Toy,
    system: Annotated[
        str | None,
        typer.Argument(
            help="A Python file with a system of contacts: it is run. By default the toy."
        ),
    ] = None,
    port: Port = None,
    no_browser: NoBrowser = False,
    stay: Stay = False,
) -> None:
    """Open the explorer: return map, branches, motion and word under sliders, of the toy or yours.

    A Python file that defines ``map_``, ``start`` and ``window`` is run as a module, and its
    system is shown. The page is served by this machine to this machine only, and no text that is
    typed into it is executed. It ends with Ctrl-C, or when its last page was closed.

    Example: woodpecker explore --eps-n1 0.3
    """
    serve = opening(port, no_browser, stay)
    from woodpecker.explore import system_page, toy_page
    from woodpecker.explore.state import PageState

    if system is not None:
        system_page.run(system, serve)
    else:
        toy_page.run(PageState(toy=toy), serve)
    raise typer.Exit
