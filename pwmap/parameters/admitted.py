"""Which values of a parameter the assumptions admit, and samples of the others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice, pairwise
from typing import Any

from pwmap.algebra.arguments import check_mapping
from pwmap.algebra.arithmetic import rational
from pwmap.algebra.assumptions import AssumedRegion
from pwmap.algebra.exact import HIGHEST, LOWEST, Infinite, Number, degree_in, is_constant, names_of
from pwmap.algebra.inequalities import Constraint
from pwmap.algebra.samples import EmptyRegionError
from pwmap.algebra.terms import own_name
from pwmap.maps.piecewise_linear import PiecewiseLinearMap
from pwmap.parameters.axis import Axis, ResampleError, identical

Span = tuple[Number, Number]
Admitted = tuple[Any, Any, bool, bool]  # both ends of an interval, and whether they belong to it
MAX_SAMPLES = 40  # samples that are tried: few of them are not generic, and then by accident


def admitted_intervals(axis: Axis, span: Span) -> list[Admitted]:
    """The parts of a span that the assumptions admit, from left to right.

    ValueError if part of a finite span is not admitted, a value is admitted but none beside it, or
    the degree of an assumption is too high for the axis.
    """
    low, high = (end if isinstance(end, Infinite) else axis.place(end) for end in span)
    limits = _limits(axis)
    inner = [x for x in limits if low < x < high]
    found: list[Admitted] = []
    for left, right in pairwise([low, *inner, high]):
        broken = _broken(axis, axis.between(left, right))
        if broken is None:
            closed = _belongs(axis, left), _belongs(axis, right)
            if found and found[-1][1] is left and closed[0]:  # the assumption only touches zero
                start, _, starts, _ = found.pop()
                left, closed = start, (starts, closed[1])
            found.append((left, right, *closed))
        elif low > LOWEST and high < HIGHEST:
            there = f"{axis.name} = {axis.to_sympy(axis.between(left, right))}"
            raise ValueError(f"{there} in the span contradicts the assumption {broken}")
    ends = [end for interval in found for end in interval[:2]]
    for place in inner:
        is_inside = any(start < place < stop for start, stop, *_ in found)
        if not any(place is end for end in ends) and not is_inside and _belongs(axis, place):
            raise ValueError(
                f"{axis.name} = {axis.to_sympy(place)} is admitted, but no value beside it: "
                "give it that value (.at), or exclude it by another assumption"
            )
    return found


def _limits(axis: Axis) -> list[Any]:
    """Places at which assumptions begin or cease to hold, from left to right."""
    found: dict[Any, Any] = {}
    for constraint in axis.definition.region.constraints:
        for place in axis.limits(constraint) if axis.degree(constraint.polynomial) else ():
            if not identical(found.setdefault(place, place), place):
                raise ResampleError
    return sorted(found.values())


def _broken(axis: Axis, place: Any) -> Constraint | None:
    """The first assumption that does not hold at a place, or None."""
    return axis.definition.region.broken(lambda polynomial: axis.sign(polynomial, place))


def _belongs(axis: Axis, place: Any) -> bool:
    return not isinstance(place, Infinite) and _broken(axis, place) is None


# --- Samples of the other parameters --------------------------------------------------------------


def samples(
    map_: PiecewiseLinearMap, name: str, span: Span, chosen: Mapping[Any, object] | None
) -> Iterator[dict[str, Number]]:
    """Yield samples of the other parameters; ValueError if the chosen one does not fit."""
    others = {str(s) for s in map_.parameters} - {name}
    if chosen is not None:
        check_mapping("sample", chosen)
        values = {own_name(key, map_.parameters): rational(value) for key, value in chosen.items()}
        if set(values) != others:
            wanted = (
                f"a sample must give values to {sorted(others)}" if others
                else f"a sample is for parameters without a value, and {name} is the only one"
            )  # fmt: skip
            raise ValueError(f"{wanted}, got {sorted(values)}")
        broken = map_.definition.region.contains(values)
        if broken is not None:
            raise ValueError(f"the sample {dict(chosen)} contradicts the assumption {broken}")
        _ = map_.at(values)  # raises if no value is left to the parameter of the axis
        yield values
        return
    table = map_.definition.table
    coefficients = (*table.breaks, *table.slopes, *table.intercepts)
    seen: list[dict[str, Number]] = []
    for values in islice(
        _region_over_span(map_.definition.region, name, span).samples(coefficients), MAX_SAMPLES
    ):
        del values[name]
        if values not in seen:
            seen.append(values)
            yield values


def _region_over_span(region: AssumedRegion, name: str, span: Span) -> AssumedRegion:
    """The region whose samples of the other parameters satisfy the assumptions all over a span."""
    if span == (LOWEST, HIGHEST):
        return region
    index = names_of(region.ring).index(name)
    constraints: list[Constraint] = []
    for constraint in region.constraints:
        if not degree_in(constraint.polynomial, index):
            constraints.append(constraint)
            continue
        # of degree one: it holds inside if it holds at both ends, or is zero at one of them
        values = [constraint.polynomial.subs(index, end) for end in span]
        constraints += [Constraint(v, False) for v in values if not is_constant(v)]
    narrowed = AssumedRegion(region.ring, tuple(constraints))
    try:
        _ = narrowed.sample
    except EmptyRegionError:
        return region  # any sample will show what is wrong with the span
    return narrowed
