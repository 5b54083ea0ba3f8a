"""The commands ``woodpecker prove`` and ``woodpecker check``: certificates."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import pwmap
import woodpecker
from pwmap.cli.certificates import CERTIFICATE, check_each
from pwmap.cli.options import FILE
from pwmap.cli.results import results_in
from pwmap.cli.screen import in_words, option, progress, say
from woodpecker.cli.diagram import PAPER, places_of
from woodpecker.cli.options import GUESS, CommandError, Near, Out, ends, motion
from woodpecker.mechanics.toy import Toy

if TYPE_CHECKING:
    from pwmap.proofs.document import Certificate

CLOSE = 1e-3  # rad: a motion this close to the lines between the samples of a branch is on it


def prove(
    toy: Toy,
    phi_s: Near = GUESS,
    order: Annotated[int, option("Its period, in returns.", least=1)] = 1,
    span: Annotated[
        tuple[float, float] | None,
        ends("Prove its branch over this interval of eps_N1, instead of the motion alone."),
    ] = None,
    point: Annotated[
        str | None,
        option("Prove this point of its diagram in eps_N1: A, B, C, or an id such as FF2."),
    ] = None,
    out: Out = Path("out"),
) -> None:
    """Prove a periodic motion, its branch, or a border collision; write a certificate.

    Example: woodpecker prove --eps-n1 0.5 --out results
    """
    from woodpecker.base.checks import interval

    if span is not None:
        if point is not None:
            raise ValueError("either a span or a point can be proved, not both")
        span = interval("span", span, finite=True)
    with results_in(out) as results:
        orbit = motion(toy, phi_s, order)
        try:
            if point is not None:
                certificate = woodpecker.prove(_point(_diagram(toy, orbit), point), toy=toy)
            elif span is not None:
                certificate = _branch(toy, orbit, span)
            else:
                certificate = woodpecker.prove(orbit)
        except woodpecker.proofs.NotProved as answer:
            raise CommandError(f"undecided: {answer}") from None
        results.write({CERTIFICATE: certificate.save})
        say(certificate.statement)


def _diagram(toy: Toy, orbit: woodpecker.PeriodicOrbit) -> pwmap.Diagram:
    return woodpecker.continuation(toy, orbit).named(places_of(PAPER))


def _branch(toy: Toy, orbit: woodpecker.PeriodicOrbit, span: tuple[float, float]) -> Certificate:
    for hit in _diagram(toy, orbit).at(toy.eps_n1):
        if hit.branch.kind is pwmap.BranchKind.FIXED_POINT and abs(hit.x - orbit.phi_s) < CLOSE:
            with progress() as bar:
                bar.add_task("branch", total=None)
                return woodpecker.prove(hit.branch, span, toy=toy, workers=os.cpu_count() or 1)
    raise CommandError("the motion lies on no branch of its diagram")


def _point(diagram: pwmap.Diagram, name: str) -> pwmap.SpecialPoint:
    try:
        return diagram.point(name)
    except KeyError:
        known = ", ".join(
            p.name or p.id
            for p in diagram.points
            if p.kind in (pwmap.PointKind.BC, pwmap.PointKind.FF)
        )
        raise ValueError(f"there is no point {name!r} in the diagram, only {known}") from None


def check(
    files: Annotated[list[Path], typer.Argument(metavar=FILE, help="Certificates, as JSON.")],
) -> None:
    """Verify certificates with other arithmetic and other code, and say what they prove.

    Example: woodpecker check results/certificate.json
    """

    def refused(name: str, error: Exception) -> str:
        return f"Refused: {'' if isinstance(error, OSError) else f'{name}: '}{in_words(error)}"

    check_each(files, woodpecker.check_certificate, "{1}", refused)
