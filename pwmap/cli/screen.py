"""Output of the commands of both packages: tables and sentences for people, or for a program.

With ``--format`` only tables go to stdout, and sentences to stderr. In a pipe no line is broken.
"""

from __future__ import annotations

import csv
import inspect
import json
import math
import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from enum import StrEnum
from importlib import import_module
from itertools import takewhile
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table
from typer.core import TyperCommand, TyperGroup

from pwmap.algebra.arguments import shown
from pwmap.cli.interrupts import AT_ONCE, INTERRUPTED, stop_repeating

if TYPE_CHECKING:  # --help does without
    from rich.progress import Progress as Bar

NOTHING_KEPT = "Interrupted: there is nothing to keep yet"
WIDE = 100_000  # characters of a line that nothing breaks
COLUMNS = "COLUMNS"  # the environment variable for the width of lines


class Format(StrEnum):
    """What ``--format`` can ask for: several formats of pictures, one of tables on stdout."""

    PNG = "png"
    PDF = "pdf"
    SVG = "svg"
    CSV = "csv"
    JSON = "json"


TABLES = Format.CSV, Format.JSON
OfTables = StrEnum("OfTables", {"CSV": "csv", "JSON": "json"})
Formats = Annotated[
    list[Format] | None,
    typer.Option(
        "--format",
        help="Format of the pictures, png by default, or csv or json for the tables on stdout "
        "(sentences go to stderr then); repeatable, for several.",
    ),
]
TableFormat = Annotated[
    list[OfTables] | None,
    typer.Option("--format", help="For the tables on stdout; sentences go to stderr."),
]
_tables: ContextVar[Format | None] = ContextVar("_tables", default=None)
_pictures: ContextVar[tuple[Format, ...]] = ContextVar("_pictures")


class _Screen(Console):
    def on_broken_pipe(self) -> None:
        """Go on if the reader of a pipe, such as ``head``, ends first: pictures are still drawn."""
        os.dup2(os.open(os.devnull, os.O_WRONLY), self.file.fileno())


def option(
    text: str, *names: str, least: int | None = None, most: float = math.inf, **keywords: Any
) -> Any:
    """An option with its help, in which ``[rad]`` is no markup; with ``least``, a whole number."""
    if least is not None:
        named = {"metavar": f"<integer from {least} on>"}
        keywords = named | keywords | {"parser": _whole(least, most)}
    return typer.Option(*names, help=escape(text), **keywords)


def _whole(least: int, most: float) -> Callable[[object], int]:
    """A function that reads whole numbers from what was typed."""
    expected = f"a whole number of at least {least}{f' and at most {most}' * (most < math.inf)}"

    def integer(text: object) -> int:
        try:
            found = int(str(text))
        except ValueError:
            found = least - 1
        if not least <= found <= most:
            raise typer.BadParameter(f"{expected} is expected, got {shown(text)}")
        return found

    return integer


def take_formats(asked: Iterable[StrEnum] | None) -> None:
    """Set the formats of pictures and of tables on stdout; ValueError for two formats of tables."""
    listed = [*dict.fromkeys(Format(each.value) for each in asked or ())]
    tables = [each for each in listed if each in TABLES]
    if len(tables) > 1:
        raise ValueError(f"--format takes one of csv and json, got {' and '.join(tables)}")
    _tables.set(tables[0] if tables else None)
    pictures = tuple(each for each in listed if each not in TABLES)
    _pictures.set(pictures or (Format.PNG,))


def pictures(name: str) -> list[str]:
    """The files into which a picture is written, one in each of the formats asked for."""
    return [f"{name}.{form}" for form in _pictures.get()]


def screen(*, stderr: bool = False, width: int | None = None) -> Console:
    """A console, by default as wide as the terminal, that shows brackets as they are."""
    return _Screen(stderr=stderr, width=width, markup=False, emoji=False)


def show(*tables: Table) -> None:
    """Print tables on stdout in the format that was asked for; for programs cells are text."""
    console = screen()
    try:
        _show(console, tables)
        console.file.flush()
    except BrokenPipeError:
        console.on_broken_pipe()


def _show(console: Console, tables: Iterable[Table]) -> None:
    form = _tables.get()
    for number, table in enumerate(tables):
        header = [str(column.header) for column in table.columns]
        cells = ([str(c).replace("\n", "; ") for c in column.cells] for column in table.columns)
        rows = [*zip(*cells, strict=True)]
        if form is Format.CSV:
            console.file.write("\n" if number else "")
            csv.writer(console.file, lineterminator="\n").writerows([header, *rows])
        elif form is Format.JSON:
            content = {"table": str(table.title or ""), "columns": header, "rows": rows}
            console.file.write(json.dumps(content, ensure_ascii=False) + "\n")
        elif console.is_terminal or os.environ.get(COLUMNS):
            console.print(table)
        else:
            _print_unwrapped(table)


def _print_unwrapped(table: Table) -> None:
    """Print a table without breaking lines; rich would wrap title and caption to its width."""
    console, title, caption = screen(width=WIDE), table.title, table.caption
    table.title = table.caption = None
    for part in (title, table, caption):
        if part:
            console.print(part, highlight=False)


def say(sentence: str) -> None:
    """Print a sentence without breaking it: on stdout, or on stderr beside tables for a program."""
    screen(stderr=_tables.get() is not None).print(sentence, highlight=False, soft_wrap=True)


def complain(sentence: str, style: str = "red") -> None:
    """Print a sentence about what went wrong on stderr; if that is full the exit status tells."""
    with suppress(OSError):
        screen(stderr=True).print(sentence, style=style, highlight=False, soft_wrap=True)


def table(columns: Iterable[str], rows: Iterable[Iterable[str]], title: str | None = None) -> Table:
    """A table of text for people."""
    found = Table(*columns, title=title)
    for row in rows:
        found.add_row(*row)
    return found


def progress() -> Bar:
    """A progress bar that leaves nothing behind, and shows only on a terminal."""
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = screen(stderr=True)
    return Progress(
        TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn(),
        console=console, transient=True, disable=not console.is_terminal,
    )  # fmt: skip


@contextmanager
def told(interrupted: str, *failures: type[BaseException]) -> Iterator[None]:
    """End a command with a sentence on an interrupt, a wrong input, or a failure."""
    kinds: tuple[type[BaseException], ...] = (MemoryError, *failures)
    try:
        yield
    except KeyboardInterrupt:
        stop_repeating()
        sentence, status = interrupted, INTERRUPTED
    except kinds as failure:
        sentence, status = f"Failed: {in_words(failure)}", 1
    except (ValueError, TypeError, OSError) as error:
        sentence, status = f"Error: {in_words(error)}", 2
    else:
        return
    complain(sentence)
    raise typer.Exit(status)


def in_words(error: BaseException) -> str:
    """The sentence of an error, without the error number of the operating system."""
    if isinstance(error, MemoryError):
        return str(error) or "no memory is left"
    if isinstance(error, IsADirectoryError) and error.filename is not None:
        return f"{error.filename}: this is a folder, and a file is expected"
    if isinstance(error, OSError) and error.strerror and error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    if isinstance(error, OSError) and error.strerror:  # of a stream, such as a full stdout
        return error.strerror
    return str(error)


@contextmanager
def _interrupted_at_once() -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        stop_repeating()
        complain(AT_ONCE)
        raise typer.Exit(INTERRUPTED) from None


USAGE: Any = typer.BadParameter.__base__  # base of all errors in what was typed, in any release


class OneSentence(TyperGroup):
    """The commands of a program; what is wrong with their options is said in one line."""

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        """Read what was typed."""
        with _interrupted_at_once():
            return super().make_context(*arguments, **options)

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        try:
            with _interrupted_at_once():
                return super().invoke(ctx)
        except USAGE as error:
            what, where = error.format_message().rstrip("."), error.ctx or ctx
            what = what.replace("Value error, ", "")  # of the library that reads choices
            complain(f"Error: {what}; see {where.command_path} --help")
            raise typer.Exit(2) from None


class OnceEach(TyperCommand):
    """A command that refuses an option that is given twice, unless it is repeatable or a flag."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read what was typed."""
        try:
            self._check_pairs(args)
            given: list[Any] = self.make_parser(ctx).parse_args(args=[*args])[2]
            for each in given:
                if given.count(each) > 1 and not (each.multiple or each.is_flag):
                    raise USAGE(f"{each.opts[0]} may be given only once")
            return super().parse_args(ctx, args)
        except USAGE as error:
            error.ctx = error.ctx or ctx  # the command whose help is named
            raise

    def _check_pairs(self, args: list[str]) -> None:
        # An option of two values that is given one takes the next option for the other one.
        pairs = {name for each in self.params if each.nargs == 2 for name in each.opts}
        for k, typed in enumerate(args):
            name, equals, first = typed.partition("=")
            if name in pairs:
                after = ([first] if equals else []) + args[k + 1 :]
                values = list(takewhile(lambda each: not each.startswith("--"), after[:2]))
                if len(values) < 2 or any("," in each for each in values):
                    got = next((each for each in values if "," in each), " ".join(values))
                    raise USAGE(f"{name} takes two values, such as {name} -2 2, got {got!r}")


def number(text: str) -> float:
    """A number that was typed."""
    try:
        return float(text)
    except ValueError:
        raise typer.BadParameter(f"a number such as 0.5 is expected, got {text!r}") from None


def command_line(package: str, text: str) -> typer.Typer:
    """A command line, without commands yet, that can say its version and draws into files only."""
    app = typer.Typer(
        cls=OneSentence,
        help=text,
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode="rich",
        context_settings={"help_option_names": ["-h", "--help"]},
    )

    def tell(asked: bool) -> None:
        if asked:
            say(f"{package} {import_module(package).__version__}")
            raise typer.Exit

    version = typer.Option(
        False, "--version", help="Print the version and leave.", callback=tell, is_eager=True
    )

    @app.callback(help=text)
    def before(_: bool = version) -> None:
        os.environ["MPLBACKEND"] = "Agg"  # it must be set before matplotlib is loaded

    return app


def prepare(app: typer.Typer) -> None:
    """Let the help of each command wrap at the width of the screen, and read options once each."""
    for command in app.registered_commands:
        command.cls = OnceEach
        text = inspect.getdoc(command.callback) or ""
        paragraphs = (" ".join(each.split()) for each in text.split("\n\n"))
        command.help = "\n\n".join(paragraphs)
