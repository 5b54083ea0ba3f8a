"""The commands ``pwmap prove`` and ``pwmap check``: certificates of maps given as text."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated

import typer

import pwmap
from pwmap.cli.interrupts import INTERRUPTED, stop_repeating
from pwmap.cli.options import FILE, Ends, Formula, Given, Values, Variable, path
from pwmap.cli.reading import assignments, exact_span, map_of, orders_of
from pwmap.cli.screen import NOTHING_KEPT, complain, in_words, option, say, told
from pwmap.diagrams.files import json_file
from pwmap.diagrams.record import files_of, record_of

CERTIFICATE = "certificate.json"  # the file, if a folder is given


def prove_map(
    formula: Formula,
    set_: Values = None,
    order: Annotated[
        int | None,
        option("The iterate, where all parameters have values; by default the map.", least=1),
    ] = None,
    parameter: Annotated[
        str | None, option("The parameter to vary; then the diagram is certified.")
    ] = None,
    orders: Annotated[
        str | None,
        option("Iterates of the diagram, such as 1,2,4 or 1-8, with all divisors; by default 1,2."),
    ] = None,
    span: Ends = None,
    given: Given = None,
    variable: Variable = "x",
    out: Annotated[
        Path,
        option(
            "File of the certificate, or a folder for certificate.json.", metavar=FILE, parser=path
        ),
    ] = Path(CERTIFICATE),
) -> None:
    """Write a certificate of fixed points and jumps, and print what it proves.

    Example: pwmap prove "Piecewise((r - 2, x <= 0), (r - a*x, True))" --set a=5/4 --set r=1
    --order 4
    """
    from pwmap.algebra.terms import checked_parameter
    from pwmap.parameters.cells import with_divisors

    with told(NOTHING_KEPT):
        if parameter is None and (orders is not None or span is not None):
            raise ValueError("--orders and --span are those of a diagram, and need a --parameter")
        if parameter is not None and order is not None:
            raise ValueError("--order is that of a map; a diagram over a --parameter has --orders")
        if not out.is_dir():
            json_file(out)
        map_ = map_of(formula, variable, given or (), assignments(set_ or ()))
        if parameter is not None:
            checked_parameter(parameter, map_.parameters)
        elif map_.parameters:
            first = map_.parameters[0]
            raise ValueError(
                f"{first} has no value: give it one, such as --set {first}=1, or certify the "
                f"diagram over it by --parameter {first}"
            )
        found: pwmap.proofs.Certificate
        if parameter is None:
            found = pwmap.prove(map_, order=1 if order is None else order)
        else:
            wanted = with_divisors(orders_of("1,2" if orders is None else orders))
            diagram = pwmap.bifurcation_diagram(map_, parameter, exact_span(span), wanted)
            found = pwmap.prove(diagram, map_, orders=wanted)
        if out.is_dir() or not (out.suffix or out.exists()):
            out.mkdir(parents=True, exist_ok=True)
            out /= CERTIFICATE
        if out.is_file():
            say(f"replaces {out}")
        found.save(out)
    try:
        say(found.statement)
        say(f"wrote {out}")
    except OSError as error:
        complain(f"wrote {out}", style="")
        complain(f"Failed: {in_words(error)}; the certificate is there")
        raise typer.Exit(1) from None


def if_a_record(file: Path) -> str:
    """A sentence if a file is the record of a command, not a certificate; otherwise empty."""
    if not file.match(record_of("*")) or not file.is_file() or not files_of(file):
        return ""
    beside = ", ".join(str(file.with_name(name)) for name in files_of(file))
    certificate = f"; check {beside}" if file.name == record_of("prove") else ""
    return f"it is the record of a command and no certificate{certificate}"


def check_files(
    files: Annotated[list[Path], typer.Argument(metavar=FILE, help="Certificates.")],
) -> None:
    """Verify certificates from their files alone, and print what they prove.

    The exit status is 1 if one of them is refused. Example: pwmap check certificate.json
    """
    check_each(
        files, pwmap.check_certificate, "{}: {}", lambda name, why: f"{name} is refused: {why}"
    )


def check_each(
    files: Iterable[Path], check: Callable[[Path], str], proved: str,
    refused: Callable[[str, Exception], str],
) -> None:  # fmt: skip
    """Say what each certificate proves, or why it is refused; exit with 1 if any is."""
    status = 0
    for file in files:
        name = str(file).encode(errors="backslashreplace").decode()
        try:
            if record := if_a_record(file):
                raise ValueError(record)
            statement = check(file)
        except (ValueError, OSError) as error:
            status = 1
            complain(refused(name, error))
        except MemoryError as error:
            complain(f"Failed: {in_words(error)} while {name} was checked")
            raise typer.Exit(1) from None
        except KeyboardInterrupt:
            stop_repeating()
            complain(f"Interrupted while {name} was checked")
            raise typer.Exit(INTERRUPTED) from None
        else:
            say(proved.format(name, statement))
    raise typer.Exit(status)
