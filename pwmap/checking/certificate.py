"""Certificates as files: head, seal and statement."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NoReturn

from pwmap.checking.branches import KINDS
from pwmap.checking.lists import fixed_points_statement
from pwmap.checking.points import diagram_statement
from pwmap.checking.reading import canonical, fields, shown
from pwmap.checking.refusing import BYTES, DIGITS, Refused, brief, refuse

FORMAT = "certificate of a piecewise-linear map"
FIXED_POINTS, DIAGRAM = "fixed points", "diagram"


HEAD = ("format", "version", "kind", "statement", "seal", "map")
STATEMENTS: Mapping[str, tuple[Callable[[Mapping[str, Any]], str], tuple[str, ...]]] = {
    FIXED_POINTS: (fixed_points_statement, ("order", *KINDS)),
    DIAGRAM: (diagram_statement, ("orders", "edges", *KINDS, "points")),
}


def seal_of(certificate: Mapping[str, Any]) -> str:
    """The SHA-256 digest of a certificate without its seal."""
    rest = {name: value for name, value in certificate.items() if name != "seal"}
    return hashlib.sha256(canonical(rest).encode("ascii")).hexdigest()


def statement_of(certificate: object) -> str:
    """The sentence that a certificate proves, ignoring its own statement and seal; or Refused."""
    if not isinstance(certificate, dict) or certificate.get("format") != FORMAT:
        refuse(f"this is no {FORMAT}")
    kind = certificate.get("kind")
    if type(certificate.get("version")) is not int or certificate["version"] != 1:
        refuse(f"version 1 was expected, got {shown(certificate.get('version'))}")
    if not isinstance(kind, str) or kind not in STATEMENTS:
        refuse(f"the kind must be one of {', '.join(STATEMENTS)}, got {shown(kind)}")
    verify, names = STATEMENTS[kind]
    fields(certificate, *HEAD, *names)
    return verify(certificate)


def check(certificate: object) -> str:
    """Verify the content of a certificate, and return its statement."""
    if not isinstance(certificate, dict) or certificate.get("seal") != seal_of(certificate):
        refuse("the seal is not that of the content")
    statement = statement_of(certificate)
    if certificate["statement"] != statement:
        refuse(f"the statement must be: {brief(statement, DIGITS)}")
    return statement


def read(path: str | os.PathLike[str], most: int = BYTES) -> object:
    """The content of a JSON file; refused if a name occurs twice or a number is no integer."""

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        if len(dict(pairs)) < len(pairs):
            refuse("a name occurs twice")
        return dict(pairs)

    def none(found: str) -> NoReturn:
        refuse(f"numbers of a certificate must be integers or text, got {found[:DIGITS]}")

    if not isinstance(path, str | os.PathLike):
        refuse(f"the path of a file was expected, got {brief(repr(path))}")
    try:
        if Path(path).exists() and not Path(path).is_file():  # reading a pipe could block
            refuse(f"cannot read the file: {brief(str(path))} is no regular file")
        with Path(path).open("rb") as file:
            data = file.read(most + 1)
    except (OSError, ValueError) as error:
        if isinstance(error, Refused):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        refuse(f"cannot read the file: {brief(reason, DIGITS)}")
    if len(data) > most:
        refuse(f"a certificate of at most {most} bytes was expected")
    try:
        return json.loads(
            data.decode("utf-8"), object_pairs_hook=unique, parse_float=none, parse_constant=none
        )
    except (ValueError, RecursionError) as error:
        if isinstance(error, Refused):
            raise
        refuse(f"this is no JSON: {error}")


def check_certificate(path: str | os.PathLike[str]) -> str:
    """Verify a certificate from its file alone, and state what it proves.

    Parameters
    ----------
    path
        A file that :func:`pwmap.prove` wrote.

    Returns
    -------
    str
        One sentence, composed of what was verified.

    Raises
    ------
    Refused
        If anything in the file is wrong; one sentence says what.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, check_certificate, prove
    >>> p1 = PiecewiseLinearMap.from_sympy("Piecewise((-1, x <= 0), (1 - 5*x/4, True))")
    >>> path = prove(p1, order=2).save("certificate.json")
    >>> check_certificate(path)[-56:]
    'ly on both sides of it: 4/5 (from 1 to -1, words RR|RL).'
    """
    return check(read(path))
