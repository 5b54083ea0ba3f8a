"""``prove`` and ``check_certificate``: what a user calls; ball arithmetic is loaded when it is."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pwmap.checking import check_certificate as pwmap_check
from pwmap.diagrams.diagram import Branch, SpecialPoint
from woodpecker.checking.sentences import seal_of, statement_of
from woodpecker.enclosures.not_proved import NotProved as NotProved  # what ``prove`` raises
from woodpecker.mechanics.toy import RESTITUTIONS, Toy
from woodpecker.runs import nothing
from woodpecker.shooting import PeriodicOrbit

if TYPE_CHECKING:
    from pwmap.proofs.document import Certificate

PAPER = Toy()
MAPS = "certificate of a piecewise-linear map"
MISSING = 'prove needs ball arithmetic: pip install "woodpecker-toy[proof]"'


def prove(
    what: PeriodicOrbit | Branch | SpecialPoint,
    span: tuple[float, float] | None = None,
    *,
    toy: Toy | None = None,
    parameter: str = "eps_n1",
    progress: Callable[[float], object] = nothing,
    workers: int = 1,
) -> Certificate:
    """Prove what a computation has found, in ball arithmetic.

    The data of the toy are the exact decimals that a person writes: 3/10000 for 0.0003.

    Parameters
    ----------
    what
        A periodic orbit: that there is exactly one so near, its word, its multiplier, period and
        drop between bounds. A branch of fixed points: that it goes on over the span, and how often
        it flips. A border collision at a jump, of P_1: both words and limits, and its kind.
    span
        Of a branch, the interval of the parameter. It begins on the branch and may go on beyond its
        end where that is a flip; a border collision is no part of it.
    toy
        The toy whose branch or point it is, by default the paper's; an orbit knows its own.
    parameter
        Along a branch or to a point: ``"eps_n1"``, ``"eps_n2"`` or ``"eps_n3"``.
    progress
        Called with the part of a branch that is done.
    workers
        Processes for a branch, each for a part of the span; no progress is shown then.

    Returns
    -------
    Certificate
        ``statement`` says what is proved; ``save(path)`` writes it for
        :func:`check_certificate`.

    Raises
    ------
    NotProved
        If it could not be proved; the sentence says what was open.
    ValueError, ImportError
        If it is nothing that can be proved here, a span is given of what is no branch, or another
        toy than an orbit's own; without the extra ``proof``.

    Examples
    --------
    >>> from woodpecker import Toy, prove, shoot
    >>> certificate = prove(shoot(Toy(eps_n1=0.5), -0.53))
    >>> certificate.content["multiplier"]
    ['-0.839155653047586083', '-0.839155653047585683']
    """
    try:
        from woodpecker.proofs import statements
    except ImportError as error:
        raise ImportError(MISSING) from error
    if span is not None and not isinstance(what, Branch):
        raise ValueError(f"a span is for a branch, got {span} for a {type(what).__name__}")
    if isinstance(what, PeriodicOrbit):
        if toy is not None and toy != what.toy:
            raise ValueError("an orbit is proved of its own toy, got another toy")
        return sealed(statements.prove_orbit(what))
    if parameter not in RESTITUTIONS:
        raise ValueError(f"proofs move one of {', '.join(RESTITUTIONS)}, got {parameter!r}")
    if isinstance(what, Branch):
        return sealed(
            statements.prove_branch(what, span, toy or PAPER, parameter, progress, workers)
        )
    if isinstance(what, SpecialPoint):
        return sealed(statements.prove_point(what, toy or PAPER, parameter))
    raise TypeError(
        f"prove needs a periodic orbit, a branch or a special point, got {type(what).__name__}"
    )


def sealed(content: Mapping[str, Any]) -> Certificate:
    """A certificate with the checker's sentence, and its seal."""
    from pwmap.proofs.document import Certificate

    whole = {"statement": statement_of(content), **content}
    return Certificate({**whole, "seal": seal_of(whole)})


def check_certificate(path: str | os.PathLike[str]) -> str:
    """Verify a certificate with other arithmetic and other code.

    Parameters
    ----------
    path
        A file as ``prove(...).save(path)`` writes it, here or in :mod:`pwmap`.

    Returns
    -------
    str
        What is proved, in a sentence.

    Raises
    ------
    ValueError
        If the certificate does not hold (``woodpecker.checking.pieces.Rejected``), and why.

    Examples
    --------
    >>> from woodpecker import Toy, check_certificate, prove, shoot
    >>> path = prove(shoot(Toy(), -0.53)).save("orbit.json")
    >>> check_certificate("orbit.json")[:72]
    'The Woodpecker Toy (expansion friction summed) with eps_n1 = 0.5 has exa'
    """
    from woodpecker.checking.certificate import check_certificate as checked

    if _is_of_a_map(path):
        return pwmap_check(Path(path))
    return checked(path)


def _is_of_a_map(path: str | os.PathLike[str]) -> bool:
    """Whether a file says that it is a certificate of a piecewise-linear map."""
    try:
        content = json.loads(Path(path).read_bytes())
    except (ValueError, RecursionError):
        return False  # it is none of either kind, as the checker says in its own words
    return isinstance(content, dict) and content.get("format") == MAPS
