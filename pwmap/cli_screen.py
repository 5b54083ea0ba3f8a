"""What the commands of both packages print on: text is shown as it is, brackets and all."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console

if TYPE_CHECKING:
    from rich.progress import Progress


def screen(*, stderr: bool = False, width: int | None = None) -> Console:
    """A console that takes ``[b]`` in a path, or ``[a, b]`` in a table, for what it is.

    Parameters
    ----------
    stderr
        Whether it is that of errors.
    width
        In characters; by default that of the terminal.
    """
    return Console(stderr=stderr, width=width, markup=False, emoji=False)


def bar_on(console: Console) -> Progress:
    """A progress bar that leaves nothing behind, and shows only on a terminal.

    Parameters
    ----------
    console
        What it is shown on.
    """
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    return Progress(
        TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn(),
        console=console, transient=True, disable=not console.is_terminal,
    )  # fmt: skip


def in_words(error: Exception) -> str:
    """What went wrong, without the number that an operating system has for it.

    Parameters
    ----------
    error
        What was raised.
    """
    if isinstance(error, OSError) and error.strerror and error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    return str(error)


def tell_written(
    console: Console, folder: Path, names: Sequence[str], gone: Sequence[str] = ()
) -> None:
    """Say which files were written, and which of an earlier run were removed.

    Parameters
    ----------
    console
        What it is said on.
    folder
        Where the files are.
    names, gone
        Names of both.
    """
    written = ", ".join(str(folder / name) for name in names)
    console.print(f"wrote {written}", highlight=False, soft_wrap=True)
    if gone:
        removed = "removed what an earlier run wrote: " + ", ".join(gone)
        console.print(removed, highlight=False, soft_wrap=True)
