"""Reading maps, values of parameters and orders from the text of a command."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import chain
from typing import TYPE_CHECKING

import pwmap
from pwmap.algebra.texts import exact

if TYPE_CHECKING:
    from pwmap.algebra.terms import Term

AS_TEXT = (
    'a map is typed as "Piecewise((r - 2, x <= 0), (r - a*x, True))", and one with roots or other '
    "functions is followed from Python, by woodpecker.from_sympy"
)


def map_of(
    formula: str, variable: str, given: Iterable[str], values: Mapping[str, str], *varied: str
) -> pwmap.PiecewiseLinearMap:
    """A map from text, with values of parameters; ValueError if it is none or lacks one of them.

    Parameters that are to be ``varied`` may have no value.
    """
    from pwmap.algebra.assumptions import AssumedRegion, read_constraints
    from pwmap.algebra.exact import sign
    from pwmap.algebra.parsing import checked_name, term_of
    from pwmap.algebra.terms import checked_parameter, own_name, plain_name

    try:
        term = term_of(formula)
    except ValueError as error:
        raise ValueError(f"{error}; {AS_TEXT}") from None
    x = checked_name(variable)
    symbols = sorted((s for name, s in term.names().items() if name != x), key=str)
    for name in varied:
        checked_parameter(name, symbols)
        if name in values:
            raise ValueError(f"{name} is to vary, and cannot be set to {values[name]} too")
    conditions = [*map(_condition, given)]
    for condition in conditions:
        for name in condition.names():
            if own_name(name, symbols) not in map(str, symbols) and name != x:
                raise ValueError(
                    f"--given {condition}: {name} is no parameter of this map, "
                    f"it has {[*map(str, symbols)]}"
                )
    numbers = {
        plain_name(checked_parameter(name, symbols)): term_of(value)
        for name, value in values.items()
    }
    # values come first, so that a denominator, or the order of two breaks, may depend on them
    read = [each.with_values(numbers) for each in (term, *conditions)]
    for condition, found in zip(conditions, read[1:], strict=True):
        if not found.names() and AssumedRegion(None, read_constraints([found], None)).broken(sign):
            given_values = ", ".join(f"{name} = {value}" for name, value in values.items())
            raise ValueError(f"{given_values} contradicts the assumption {condition}")
    return pwmap.PiecewiseLinearMap.from_sympy(read[0], variable, read[1:])


def _condition(text: str) -> Term:
    from pwmap.algebra.parsing import term_of

    with of_option("--given", text):
        return term_of(text)


ORDERS = re.compile(r"\s*(\d{1,9})\s*(?:-\s*(\d{1,9})\s*)?")  # 3 or 1-8


@contextmanager
def of_option(option: str, *texts: str) -> Iterator[None]:
    """A block whose ValueError says which option was wrong."""
    from pwmap.algebra.arguments import shortened

    try:
        yield
    except ValueError as error:
        typed = " ".join(shortened(text) if text else repr(text) for text in texts)
        raise ValueError(f"{option} {typed}: {error}") from None


def exact_span(span: tuple[str, str] | None, option: str = "--span") -> tuple[str, str] | None:
    """Both ends of an interval by :func:`exact`; ValueError if it is no interval."""
    from pwmap.parameters.cells import checked_span

    if span is None:
        return None
    low, high = exact(span[0]), exact(span[1])
    with of_option(option, *span):
        checked_span((low, high))
    return low, high


def assignments(texts: Iterable[str], option: str = "--set") -> dict[str, str]:
    """Values of parameters from texts such as a=5/4 or a=1.25; ValueError for any other text."""
    from pwmap.algebra.arithmetic import rational

    found = dict[str, str]()
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise ValueError(f"{option} needs name=value, such as a=5/4, got {text!r}")
        if "=" in value:
            raise ValueError(f"{option} takes one value, and is repeated for others, got {text!r}")
        if name in found:
            raise ValueError(f"{option} gives {name} two values, {found[name]} and {exact(value)}")
        found[name] = exact(value)
        with of_option(option, text):
            rational(found[name])
    return found


def sample_of(
    map_: pwmap.PiecewiseLinearMap, parameter: str, texts: Iterable[str]
) -> dict[str, str] | None:
    """The values of ``--sample``, or None without any; ValueError if the map forbids them."""
    from pwmap.algebra.exact import HIGHEST, LOWEST
    from pwmap.parameters.admitted import samples

    values = assignments(texts, "--sample")
    if not values:
        return None
    next(samples(map_, parameter, (LOWEST, HIGHEST), values))
    return values


def densities_of(
    map_: pwmap.PiecewiseLinearMap, parameter: str, span: tuple[str, str] | None,
    asked: bool, densities: Iterable[str],
) -> tuple[str, ...]:  # fmt: skip
    """The values of ``--density``, checked before anything is computed.

    ValueError if densities, or attractors and entropy if ``asked`` for, cannot be computed.
    """
    from pwmap.parameters.cells import check_parameters, span_of_only

    if asked and span is None:
        raise ValueError("--attractors and --entropy need an interval of the parameter: --span")
    if asked and span is not None:
        span_of_only(map_, parameter, span)
    found = tuple(dict.fromkeys(map(exact, densities)))
    for value in found:
        check_parameters(map_, f"{parameter} alone", parameter)
        with of_option("--density", value):
            map_.at({parameter: value})
    return found


def orders_of(text: str, option: str = "--orders") -> list[int]:
    """Orders from a text such as 1,2,4 or 1-8, ascending; ValueError for any other text."""
    from pwmap.parameters.cells import checked_orders

    ranges = list[range]()
    for part in text.split(","):
        found = ORDERS.fullmatch(part)
        ranges.append(range(int(found[1]), int(found[2] or found[1]) + 1) if found else range(0))
        if not ranges[-1]:
            raise ValueError(f"{option} needs integers such as 1,2,4 or 1-8, got {text!r}")
    return [*checked_orders(chain(*ranges))]
