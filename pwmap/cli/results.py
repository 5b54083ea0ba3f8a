"""The files of a command, tables before pictures, and the end that all commands share.

However a command ends, its files are named on the screen and in a record beside them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from tempfile import TemporaryFile
from typing import TYPE_CHECKING, Any

import typer

from pwmap.cli.interrupts import INTERRUPTED, farewell, held, ignore_requests, stop_repeating
from pwmap.cli.screen import complain, in_words, pictures, say
from pwmap.diagrams import files
from pwmap.diagrams.record import earlier_files, keep_record, record_of
from pwmap.maps.budget import BUDGET, Advance, Budget

if TYPE_CHECKING:  # --help does without
    from rich.progress import Progress as Bar

SUFFIXES = {".png", ".pdf", ".svg", ".gif", ".mp4", ".avi", ".mov", ".csv", ".json", ".txt"}
KEPT = "what was finished is kept"
# the command that runs, and its options, for the record
asked: ContextVar[tuple[str, Mapping[str, object]]] = ContextVar("asked")

Writers = dict[str, Callable[[Path], object]]
"""By the name of a file, the function that writes it, whole or not at all."""


def table_in(header: Sequence[str], rows: Iterable[Sequence[object]]) -> Callable[[Path], object]:
    """The function that writes a table as CSV."""
    return lambda path: files.write_table(path, header, rows)


def typed(context: typer.Context) -> dict[str, object]:
    """The options of a command by their names, without ``--out``."""
    options = {
        each.opts[0].lstrip("-").replace("-", "_"): context.params[each.name]
        for each in context.command.params
        if each.name in context.params and each.param_type_name == "option"
    }
    return {name: value for name, value in options.items() if name != "out"}


@dataclass
class Results:
    """The files that a command has written so far, and why it was broken off."""

    folder: Path
    files: Sequence[str] = ()  # that the command writes besides those of its record
    there: set[str] = field(default_factory=set)  # in the folder at first, and not yet told of
    names: list[str] = field(default_factory=list)  # of complete files
    stopped: str = ""  # why the command was broken off, as a sentence; empty if it was not
    status: int = INTERRUPTED  # the exit status if it was
    missing: str = ""  # end of that sentence, as long as there is no picture

    def replace(self, *names: str) -> None:
        """Say, before anything is written, which files of an earlier run are replaced."""
        # those of this command's own run, and those that any command wrote with the names of files
        # that come next; the folder may have been removed since it was checked
        self.folder.mkdir(parents=True, exist_ok=True)
        earlier = earlier_files(self.folder, asked.get()[0])
        named = dict.fromkeys((*earlier, *self.files, *names))
        if there := [n for n in named if n in self.there and (self.folder / n).exists()]:
            self.there.difference_update(there)
            what = f"replaces what an earlier run wrote into {self.folder}: {', '.join(there)}"
            complain(what, style="")

    def write(self, writers: Writers) -> None:
        """Write files, which a request to end does not interrupt.

        If one fails, as on a full disk, those written by then are kept and named.
        """
        self.replace(*writers)
        with held():
            for name, write in writers.items():
                write(self.folder / name)
                self.names.append(name)

    def draw(self, name: str, figure: Any) -> None:
        """Write a picture in each format that was asked for, each file whole or not at all."""
        self.replace(*pictures(name))
        for file in pictures(name):
            files.write_figure(self.folder / file, figure)
            self.names.append(file)
            self.missing = ""

    def stop(self, sentence: str, status: int = INTERRUPTED) -> None:
        """Set the reason why the command was broken off, and its exit status."""
        stop_repeating()
        self.stopped, self.status = sentence, status

    def interrupt(self) -> None:
        """Note that the command was asked to end."""
        self.stop(f"Interrupted: {KEPT}")

    def fail(self, why: str) -> None:
        """Note that something failed."""
        self.stop(f"Failed: {why}; {KEPT}", 1)

    @contextmanager
    def budget(self, bar: Bar, what: str, pieces: int = BUDGET.pieces) -> Iterator[Budget]:
        """A budget that shows progress on a bar; Ctrl-C ends only the computation under it."""
        task = bar.add_task(what, total=None)

        def tell(at: Advance) -> None:
            text = f"{what}: {at.what}" if at.what else what
            bar.update(task, description=text, completed=at.done, total=at.total or None)

        yield Budget(pieces=pieces, progress=tell, on_interrupt=self.interrupt)
        bar.update(task, visible=False)


@contextmanager
def results_in(out: Path, *files: str, kept: Sequence[str] = ()) -> Iterator[Results]:
    """The folder for the results, made before the computation.

    The command writes ``files``, besides those of its record, and continues the ``kept`` ones. If
    it ends before it has written anything, a folder that it made is removed.
    """
    _check(out)
    missing = [each for each in (out, *out.parents) if not each.exists()]
    out.mkdir(parents=True, exist_ok=True)
    _check_writable(out)
    results = Results(out, files, {path.name for path in out.iterdir()} - {*kept})
    bidden = farewell.set(partial(_bid_farewell, results, missing, farewell.get()))
    try:
        yield results
    except (KeyboardInterrupt, MemoryError, OSError) as error:
        if not results.names:
            _remove(missing)
            raise
        if isinstance(error, KeyboardInterrupt):
            results.interrupt()
        else:
            results.fail(in_words(error))
    except BaseException:
        _remove(missing)
        raise
    finally:
        farewell.reset(bidden)
    ignore_requests()
    _record(results)
    if results.stopped:
        complain(results.stopped + results.missing)
        raise typer.Exit(results.status)


def _bid_farewell(results: Results, missing: list[Path], usual: Callable[[], None]) -> None:
    """Say and record what is kept as a request ends the process; without any, remove folders."""
    begun = [file for name in results.files if (file := results.folder / name).exists()]
    if begun and not results.names:  # such as the file of a run, whose branches are in it
        complain(f"Interrupted: {KEPT}, in {', '.join(map(str, begun))}")
        return
    if not results.names:
        _remove(missing)
        usual()
        return
    if not results.stopped:
        results.interrupt()
    _record(results)
    complain(results.stopped + results.missing)


def _check(folder: Path) -> None:
    """ValueError if ``--out`` is a file, or has the name of one: it is a folder."""
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"{folder}: --out is a folder, and this is a file")
    if folder.suffix.lower() in SUFFIXES and not folder.exists():
        raise ValueError(f"{folder}: --out is a folder, and this is the name of a file")


def _check_writable(folder: Path) -> None:
    """OSError, before a long computation, if no file can be made in a folder."""
    try:
        TemporaryFile(dir=folder).close()
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(folder)) from None


def _record(results: Results) -> None:
    """Record what a command wrote, and say so."""
    command, about = asked.get()
    written, gone = [*results.names, record_of(command)], tuple[str, ...]()
    try:
        gone = keep_record(results.folder, command, results.names, about)
    except OSError as error:
        results.stop(results.stopped or f"Failed: {in_words(error)}", 1)
        written.pop()
    told = ["wrote " + ", ".join(str(results.folder / name) for name in written)]
    if gone:
        told.append("removed what an earlier run wrote: " + ", ".join(gone))
    try:
        for sentence in told:
            say(sentence)
    except OSError as error:  # stdout is full: stderr says what is kept
        results.stop(results.stopped or f"Failed: {in_words(error)}", 1)
        for sentence in told:
            complain(sentence, style="")


def _remove(folders: list[Path]) -> None:
    with suppress(OSError):  # a folder that is not empty stays
        for each in folders:
            each.rmdir()
