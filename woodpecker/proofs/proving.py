"""``prove`` and ``check_certificate``; ``prove`` loads ball arithmetic only when it is called."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pwmap.checking import certificate as of_maps
from pwmap.diagrams.diagram import Branch, SpecialPoint
from woodpecker.base.checks import instance
from woodpecker.checking.sentences import statement_of
from woodpecker.enclosures.not_proved import NotProved as NotProved  # what ``prove`` raises
from woodpecker.mechanics.toy import RESTITUTIONS, Toy
from woodpecker.runs import nothing
from woodpecker.shooting import PeriodicOrbit

if TYPE_CHECKING:
    from pwmap.proofs.document import Certificate

PAPER = Toy()
MISSING = 'prove needs ball arithmetic: pip install "woodpecker-toy[proof]"'


def prove(
    what: PeriodicOrbit | Branch | SpecialPoint,
    span: tuple[float, float] | None = None,
    *,
    toy: Toy | None = None,
    parameter: str = "eps_n1",
    progress: Callable[[float], object] | None = None,
    workers: int = 1,
) -> Certificate:
    """Prove the result of a computation in ball arithmetic.

    Parameters of the toy are exact decimals as written: 3/10000 for 0.0003.

    Parameters
    ----------
    what
        For a periodic orbit, existence, uniqueness nearby, the word, and bounds of multiplier,
        period and drop are proved. For a branch of fixed points: that it continues over the span,
        and its flips. For a border collision of P_1 at a jump: both words and limits, and its kind.
    span
        Interval of the parameter, for a branch. It begins on the branch and may extend beyond the
        branch's end if that is a flip, but not if it is a border collision.
    toy
        The toy of a branch or point, by default the paper's; an orbit knows its own.
    parameter
        That of a branch or point: ``"eps_n1"``, ``"eps_n2"`` or ``"eps_n3"``.
    progress
        Called with the fraction of a branch that is done, if there is one worker.
    workers
        Number of processes for a branch; each proves a part of the span.

    Returns
    -------
    Certificate
        ``statement`` is the theorem; ``save(path)`` writes a file for :func:`check_certificate`.

    Raises
    ------
    NotProved
        If the proof fails; the text says which decision was open.
    ValueError, TypeError, ImportError
        If ``what`` is not one of these, a span is given without a branch, or the toy is not the
        orbit's; ImportError without the extra ``proof``.

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
    if toy is not None:
        instance("toy", toy, Toy)
    if isinstance(what, PeriodicOrbit):
        if toy is not None and toy != what.toy:
            raise ValueError("an orbit is proved of its own toy, got another toy")
        return sealed(statements.prove_orbit(what))
    if parameter not in RESTITUTIONS:
        raise ValueError(f"proofs move one of {', '.join(RESTITUTIONS)}, got {parameter!r}")
    if isinstance(what, Branch):
        of, tell = toy or PAPER, progress or nothing
        return sealed(statements.prove_branch(what, span, of, parameter, tell, workers))
    if isinstance(what, SpecialPoint):
        return sealed(statements.prove_point(what, toy or PAPER, parameter))
    raise TypeError(
        f"prove needs a periodic orbit, a branch or a special point, got {type(what).__name__}"
    )


def sealed(content: Mapping[str, Any]) -> Certificate:
    """The certificate of a content, with the checker's statement and a seal."""
    from pwmap.proofs.document import Certificate

    whole = {"statement": statement_of(content), **content}
    return Certificate({**whole, "seal": of_maps.seal_of(whole)})


def check_certificate(path: str | os.PathLike[str]) -> str:
    """Verify a certificate with independent code, in different arithmetic.

    Parameters
    ----------
    path
        A file written by ``prove(...).save(path)``, here or in :mod:`pwmap`.

    Returns
    -------
    str
        The theorem that the certificate proves.

    Raises
    ------
    ValueError
        If the certificate does not hold; the text says why (``pwmap.proofs.Refused``).

    Examples
    --------
    >>> from woodpecker import Toy, check_certificate, prove, shoot
    >>> path = prove(shoot(Toy(), -0.53)).save("orbit.json")
    >>> check_certificate("orbit.json")[:72]
    'The Woodpecker Toy (expansion friction summed) with eps_n1 = 0.5 has exa'
    """
    from woodpecker.checking.certificate import LONGEST, check

    content = of_maps.read(path, LONGEST)
    if isinstance(content, dict) and content.get("format") == of_maps.FORMAT:
        return of_maps.check_certificate(path)
    return check(content)
