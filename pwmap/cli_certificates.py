"""The commands ``pwmap prove`` and ``pwmap check``: certificates of maps given as text."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, NoReturn

import typer

from pwmap.cli_reading import assignments, map_of, orders_of
from pwmap.cli_screen import in_words, screen


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
    from pwmap import Certificate, bifurcation_diagram, prove

    try:
        map_ = map_of(formula, variable, given or (), assignments(set_ or ()))
        found: Certificate
        if parameter is None:
            found = prove(map_, order=order)
        else:
            wanted = orders_of(orders)
            diagram = bifurcation_diagram(map_, parameter, span, wanted)
            found = prove(diagram, map_, orders=wanted)
        found.save(out)
    except (ValueError, TypeError, OSError) as error:
        _leave(f"Error: {in_words(error)}", 2)
    console = screen()
    console.print(found.statement, highlight=False, soft_wrap=True)
    console.print(f"wrote {out}", soft_wrap=True)


def check_files(
    files: Annotated[list[Path], typer.Argument(help="Certificates.")],
) -> None:
    """Verify certificates from nothing but their files, and print what they prove.

    All files are read; the exit status is 1 if one is refused.
    """
    from pwmap import Refused, check_certificate

    refused = 0
    for file in files:
        name = str(file).encode(errors="backslashreplace").decode()
        try:
            statement = check_certificate(file)
        except Refused as refusal:
            refused += 1
            _complain(f"{name} is refused: {refusal}")
        else:
            screen().print(f"{name}: {statement}", highlight=False, soft_wrap=True)
    if refused:
        raise typer.Exit(1)


def _complain(text: str) -> None:
    screen(stderr=True).print(text, style="red", highlight=False, soft_wrap=True)


def _leave(text: str, status: int) -> NoReturn:
    _complain(text)
    raise typer.Exit(status) from None
