"""The commands ``pwmap prove`` and ``pwmap check``: certificates of maps given as text."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, NoReturn

import typer

from pwmap.cli.reading import assignments, exact_span, map_of, orders_of
from pwmap.cli.screen import complain, in_words, say

INTERRUPTED = 130  # exit status, as of a shell's command that Ctrl-C has ended


def prove_map(
    formula: Annotated[str, typer.Argument(help="The map, as the text of a sympy Piecewise.")],
    set_: Annotated[
        list[str] | None,
        typer.Option("--set", help="Value of a parameter, such as a=5/4; repeatable."),
    ] = None,
    order: Annotated[int, typer.Option(help="The iterate, where all parameters have values.")] = 1,
    parameter: Annotated[
        str | None, typer.Option(help="The parameter to vary; then the diagram is certified.")
    ] = None,
    orders: Annotated[str, typer.Option(help="Iterates of the diagram, such as 1,2,3.")] = "1,2",
    span: Annotated[
        tuple[str, str] | None,
        typer.Option(help="Two rationals; by default all that happens.", show_default=False),
    ] = None,
    given: Annotated[
        list[str] | None, typer.Option(help="An assumption on the parameters, such as 'a > 1'.")
    ] = None,
    variable: Annotated[str, typer.Option(help="The variable of the map.")] = "x",
    out: Annotated[Path, typer.Option(help="File of the certificate.")] = Path("certificate.json"),
) -> None:
    """Write a certificate of fixed points and jumps, and print what it proves.

    Example: pwmap prove "Piecewise((r - 2, x <= 0), (r - a*x, True))" --set a=5/4 --set r=1
    --order 4
    """
    from pwmap import bifurcation_diagram, prove
    from pwmap.proofs import Certificate

    try:
        if out.exists():
            say(f"replaces {out}")
        map_ = map_of(formula, variable, given or (), assignments(set_ or ()))
        found: Certificate
        if parameter is None:
            found = prove(map_, order=order)
        else:
            wanted = orders_of(orders)
            diagram = bifurcation_diagram(map_, parameter, exact_span(span), wanted)
            found = prove(diagram, map_, orders=wanted)
        found.save(out)
    except KeyboardInterrupt:
        _leave("Interrupted: there is nothing to keep yet", INTERRUPTED)
    except (ValueError, TypeError, OSError) as error:
        _leave(f"Error: {in_words(error)}", 2)
    say(found.statement)
    say(f"wrote {out}")


def check_files(
    files: Annotated[list[Path], typer.Argument(help="Certificates.")],
) -> None:
    """Verify certificates from nothing but their files, and print what they prove.

    All files are read; the exit status is 1 if one is refused.
    """
    from pwmap.checking import Refused, check_certificate

    refused = 0
    for file in files:
        name = str(file).encode(errors="backslashreplace").decode()
        try:
            statement = check_certificate(file)
        except Refused as refusal:
            refused += 1
            complain(f"{name} is refused: {refusal}")
        except KeyboardInterrupt:
            _leave(f"Interrupted while {name} was checked", INTERRUPTED)
        else:
            say(f"{name}: {statement}")
    if refused:
        raise typer.Exit(1)


def _leave(text: str, status: int) -> NoReturn:
    complain(text)
    raise typer.Exit(status) from None
