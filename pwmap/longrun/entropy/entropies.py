"""Topological entropy: exact for finite critical orbits, otherwise enclosed.

The laps of the iterates, their affine pieces, are the paths in a graph [Hofbauer1979]. Its nodes
are intervals on which the map is affine: the pieces, and the parts into which breaks cut the image
of a node. The growth rate of laps is the spectral radius of the graph, an algebraic number if that
is finite. Of an infinite graph, the nodes beyond some order are left out for a lower bound, and
replaced by whole pieces for an upper one; the error decreases like the growth to minus the order.
Intervals whose orbits converge to a cycle or tend to infinity add no growth, and are left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from fractions import Fraction

import networkx as nx
import numpy as np
import sympy
from sympy import QQ, ZZ
from sympy.polys.matrices import DomainMatrix

from pwmap.algebra.exact import HIGHEST, LOWEST
from pwmap.algebra.numbers import Element, Exact, log_bounds
from pwmap.algebra.roots import Real, RealRoot, real_roots, real_to_sympy
from pwmap.algebra.texts import printable
from pwmap.longrun.attractors import Attractors
from pwmap.longrun.fates import escapes
from pwmap.longrun.line import Interval, MapLine, cut_at, difference
from pwmap.maps.budget import Meter
from pwmap.maps.words import work_of

Node = tuple[int, Exact, Exact]  # the index of a branch, and an interval inside its domain
LARGEST = 48  # rows of a matrix whose characteristic polynomial is factored, at most
PERRON_SCALE = 2**52  # by which the Perron vector is multiplied before it is rounded to integers
ROUNDS = 4000  # of the power method for that vector, at most
PERRON_TOLERANCE = 2.0**-50  # change of the vector in one round below which it has converged
ORDERS = (12, 24, 48, 96)  # up to which the graph is built, in turn
STEP = 10  # operations for the edges that leave a node
WIDTH = 1e-12  # difference of bounds that are close enough


@printable
@dataclass(frozen=True, slots=True, kw_only=True)
class Entropy:
    """The topological entropy of a map: the growth rate of its laps, as a natural logarithm.

    ``low`` and ``high`` are doubles below and above it; ``value`` is the logarithm of an algebraic
    number, or None if it is not known exactly. The graph of laps was built up to the ``order``.
    ``left_out`` is a sentence if a budget or an interrupt ended the search for closer bounds.

    Examples
    --------
    >>> from sympy import sqrt
    >>> from pwmap import PiecewiseLinearMap, dynamics
    >>> tent = PiecewiseLinearMap.from_sympy("Piecewise((a*x, x <= 1/2), (a*(1 - x), True))")
    >>> dynamics(tent, {"a": (1 + sqrt(5))/2}).entropy.value
    log(1/2 + sqrt(5)/2)
    """

    low: float
    high: float
    value: sympy.Expr | None
    order: int
    left_out: str = ""

    @property
    def is_exact(self) -> bool:
        """Whether it is known exactly."""
        return self.value is not None


Successors = tuple[tuple[int, ...], ...]  # for each node the indices of its successors


def lap_graphs(
    line: MapLine, found: Attractors, order: int, meter: Meter
) -> tuple[Successors, Successors]:
    """The graph of laps up to an order: later nodes left out, and replaced by whole pieces."""
    # laps do not grow in number where orbits tend to infinity or converge to a cycle
    below, above = escapes(line)
    drawn = sorted(part for cycle in found.cycles for part in cycle.region.interior)
    ends = ((LOWEST, below), *drawn, (above, HIGHEST))
    cut_off = [part for part in ends if part[0] < part[1]]
    pieces = [(k, *part) for k, branch in enumerate(line.branches)
              for part in difference([(branch.lower, branch.upper)], cut_off)]  # fmt: skip
    number = {node: k for k, node in enumerate(pieces)}
    first = [[number[node] for node in pieces if node[0] == k] for k in range(len(line.branches))]
    leads, newest = list[list[Node]](), list(pieces)
    for _ in range(order):
        meter.spend(sum(map(_work, newest)))
        onward = [list(_successors(line, node, cut_off)) for node in newest]
        leads += onward
        newest = list(dict.fromkeys(n for nodes in onward for n in nodes if n not in number))
        for node in newest:
            number[node] = len(number)
    known = len(leads)
    inner = [[(number[node], node[0]) for node in onward] for onward in leads]
    ways = tuple(tuple(n for n, _ in onward if n < known) for onward in inner)
    whole = tuple(
        tuple(other for n, k in onward for other in ((n,) if n < known else first[k]))
        for onward in inner
    )
    return ways, whole


def _work(node: Node) -> int:
    return STEP + 3 * sum(map(work_of, node[1:]))


def _successors(line: MapLine, node: Node, cut_off: Sequence[Interval]) -> Iterator[Node]:
    k, low, high = node
    branch = line.branches[k]
    if not branch.slope:
        return
    for image in difference([branch.over((low, high))], cut_off):
        yield from ((number, *part) for number, part in cut_at(line.breaks, image))


def entropy_of(line: MapLine, found: Attractors, orders: Sequence[int], meter: Meter) -> Entropy:
    """The topological entropy, from graphs of increasing order until its bounds are close."""
    # a step multiplies the number of laps by at most the number of branches
    most = math.nextafter(math.log(len(line.branches)), math.inf)
    best = Entropy(low=0.0, high=most, value=None, order=0)
    with meter.keeping(orders):
        for order in meter.each(orders, "orders"):
            ways, whole = lap_graphs(line, found, order, meter)
            if ways == whole:
                growth = growth_of(ways)
                if growth is not None:
                    return exact_entropy(growth, order)
            low = max(best.low, _log(spectral_bounds(ways)[0])[0])
            high = min(best.high, _log(spectral_bounds(whole)[1])[1])
            best = Entropy(low=low, high=high, value=None, order=order)
            if ways == whole or high - low <= WIDTH:
                break
    if meter.stopped:
        best = replace(best, left_out=f"stopped after order {best.order}: {meter.stopped}")
    return best


def exact_entropy(growth: Real, order: int) -> Entropy:
    """The entropy of a map whose laps grow like the powers of ``growth``, at least 1."""
    number = Element(growth, (QQ.one, QQ.zero)) if isinstance(growth, RealRoot) else growth
    low, high = (0.0, 0.0) if growth == 1 else log_bounds(number)
    return Entropy(low=low, high=high, value=sympy.log(real_to_sympy(growth)), order=order)


def _log(x: Fraction) -> tuple[float, float]:
    """Doubles below and above the logarithm of a fraction; both 0 if that is negative."""
    return log_bounds(QQ(x.numerator, x.denominator)) if x > 1 else (0.0, 0.0)


def _components(ways: Sequence[Sequence[int]]) -> list[list[int]]:
    """The strongly connected components of a graph that contain a cycle."""
    graph = nx.DiGraph((k, other) for k, others in enumerate(ways) for other in others)
    return [
        sorted(each)
        for each in nx.strongly_connected_components(graph)
        if len(each) > 1 or graph.has_edge(*(2 * tuple(each)))
    ]


def spectral_bounds(ways: Sequence[Sequence[int]]) -> tuple[Fraction, Fraction]:
    """Fractions below and above the spectral radius of a graph."""
    low = high = Fraction(0)
    for nodes in _components(ways):
        number = {node: k for k, node in enumerate(nodes)}
        inner = [(k, number[n]) for node, k in number.items() for n in ways[node] if n in number]
        vector = _perron(inner, len(nodes))
        image = [0] * len(nodes)
        for k, other in inner:
            image[k] += vector[other]
        # for any positive v the radius lies between the extreme (A v)_i / v_i [Collatz1942]
        quotients = [Fraction(a, b) for a, b in zip(image, vector, strict=True)]
        low, high = max(low, min(quotients)), max(high, max(quotients))
    return low, high


def _perron(ways: Sequence[tuple[int, int]], size: int) -> list[int]:
    """An approximate Perron eigenvector of an irreducible matrix, in positive integers."""
    rows, columns = (np.array(each) for each in zip(*ways, strict=True))
    vector = np.ones(size)
    for _ in range(ROUNDS):
        # by I + A, which is aperiodic even where A is not
        image = vector + np.bincount(rows, weights=vector[columns], minlength=size)
        image /= image.max()
        change = np.abs(image - vector).max()
        vector = image
        if change < PERRON_TOLERANCE:
            break
    return [int(x * PERRON_SCALE) + 1 for x in vector]


def growth_of(ways: Sequence[Sequence[int]]) -> Real | None:
    """The spectral radius of a graph, at least 1; None if a component is too large."""
    best: Real = QQ.one
    for nodes in _components(ways):
        if len(nodes) > LARGEST:
            return None
        rows = [[ZZ(ways[node].count(other)) for other in nodes] for node in nodes]
        polynomial = DomainMatrix(rows, (len(nodes), len(nodes)), ZZ).charpoly()
        best = max(best, real_roots([QQ(int(c)) for c in polynomial])[-1])
    return best


def lap_numbers(line: MapLine, order: int, meter: Meter) -> list[int]:
    """The numbers of laps of the iterates up to an order, counted as paths in their graph."""
    found = list[int]()
    counted = {(k, branch.lower, branch.upper): 1 for k, branch in enumerate(line.branches)}
    ended = 0
    for _ in range(order):
        found.append(sum(counted.values()) + ended)
        meter.spend(sum(map(_work, counted)))
        more = dict[Node, int]()
        for node, times in counted.items():
            # an interval that is mapped to a point stays one lap
            if not line.branches[node[0]].slope:
                ended += times
            for other in _successors(line, node, ()):
                more[other] = more.get(other, 0) + times
        counted = more
    return found


# --- Over a parameter -----------------------------------------------------------------------------


class GapCause(Enum):
    """Why nothing is proved for an interval; the value says it in words."""

    EXPANDS = "every piece expands, so that nothing attracts, and orbits of breaks go on"
    OPEN = "orbits of breaks are not known to the end after as many steps"
    NARROW = "it is narrower than the tolerance"
    BUDGET = "as many samples as were allowed have been taken, or the budget is used up"
    SPECIAL = "all samples tried are places at which orbits of breaks meet"
    LARGE = "the kneading determinant has too high a degree"


@printable
@dataclass(frozen=True, slots=True, kw_only=True)
class ConstantEntropy:
    """An interval of constant topological entropy, of :func:`pwmap.constant_entropy`.

    The ends are exact; ``closed`` tells for each whether it is known to have the same entropy.
    ``samples`` are rationals inside, one for each part with a proof of its own; ``cycles`` are the
    words of the attracting cycles there.
    """

    lower: sympy.Expr
    upper: sympy.Expr
    closed: tuple[bool, bool]
    entropy: Entropy
    samples: tuple[sympy.Rational, ...]
    cycles: tuple[str, ...]


@printable
@dataclass(frozen=True, slots=True, kw_only=True)
class EntropyGap:
    """An interval for which :func:`pwmap.constant_entropy` proved nothing, and why."""

    lower: sympy.Expr
    upper: sympy.Expr
    causes: tuple[GapCause, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class EntropyIntervals:
    """The result of :func:`pwmap.constant_entropy` over an interval of a parameter.

    ``intervals`` are disjoint, or touch with different entropies; ``gaps`` lie between them.
    """

    parameter: sympy.Symbol
    intervals: tuple[ConstantEntropy, ...]
    gaps: tuple[EntropyGap, ...]

    @property
    def share(self) -> float:
        """The fraction of the span that the intervals cover, from 0 to 1."""
        covered, left = (
            sum(float(each.upper - each.lower) for each in group)
            for group in (self.intervals, self.gaps)
        )
        return covered / (covered + left)
