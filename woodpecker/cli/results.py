"""The files of a command: tables, then pictures, and the same end for all commands.

However a command ends, its files are named on the screen and in a record beside them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import typer

from pwmap.cli.screen import (
    INTERRUPTED,
    check_folder,
    complain,
    draw,
    in_words,
    record,
    tell_replaced,
)
from pwmap.diagrams.files import write_table
from woodpecker.cli.interrupts import finished, heard, held

# the command that runs and its arguments, the toy and the options, for the record
asked: ContextVar[tuple[str, Mapping[str, object]]] = ContextVar("asked")

CsvTable = tuple[str, Sequence[str], Iterable[Sequence[object]]]
"""The name of a file, its header and its rows."""


@dataclass
class Results:
    """The files of a command so far."""

    folder: Path
    names: list[str] = field(default_factory=list)  # of complete files
    stopped: str = ""  # why the command was broken off, as a sentence; empty if it was not
    status: int = INTERRUPTED  # the exit status then

    @contextmanager
    def tables(self, *names: str) -> Iterator[Path]:
        """A block that writes tables, which a request to end does not interrupt."""
        with held():
            yield self.folder
            self.names += names

    def write(self, tables: Iterable[CsvTable]) -> None:
        """Write tables, which a request to end does not interrupt."""
        with held():
            for name, header, rows in tables:
                write_table(self.folder / name, header, rows)
                self.names.append(name)

    def draw(self, name: str, figure: Any) -> None:
        """Write a picture, each file whole or not at all."""
        for file in draw(self.folder, name, figure):
            self.names.append(file)

    def stop(self, sentence: str, status: int = INTERRUPTED) -> None:
        """Set the reason why the command was broken off, and its exit status."""
        heard()
        self.stopped, self.status = sentence, status


@contextmanager
def results_in(out: Path, *files: str, kept: Sequence[str] = ()) -> Iterator[Results]:
    """The folder for the results, made before the computation.

    The command writes ``files``, besides those of its record, and continues the ``kept`` ones. If
    it ends before it has written anything, a folder that it made is removed.
    """
    check_folder(out)
    missing = [each for each in (out, *out.parents) if not each.exists()]
    out.mkdir(parents=True, exist_ok=True)
    command, about = asked.get()
    tell_replaced(out, command, *files, kept=kept)
    results = Results(out)
    try:
        yield results
    except KeyboardInterrupt:
        if not results.names:
            _remove(missing)
            raise
        results.stop("Interrupted: what was finished is kept")
    except OSError as error:
        if not results.names:
            _remove(missing)
            raise
        results.stop(f"Failed: {in_words(error)}; what was finished is kept", 1)
    except BaseException:
        _remove(missing)
        raise
    finished()
    if missing_record := record(out, command, results.names, about):
        results.stop(results.stopped or f"Failed: {missing_record}", 1)
    if results.stopped:
        complain(results.stopped)
        raise typer.Exit(results.status)


def _remove(folders: list[Path]) -> None:
    with suppress(OSError):  # there is something in it
        for each in folders:
            each.rmdir()
