"""Help of options, in which ``[rad]`` is a unit and no markup."""

from __future__ import annotations

from typing import Any

import typer
from rich.markup import escape


def option(text: str, *names: str, **keywords: Any) -> Any:
    """An option with its help."""
    return typer.Option(*names, help=escape(text), **keywords)
