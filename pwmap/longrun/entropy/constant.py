"""Parameter intervals on which the topological entropy is proved to be constant.

At a rational sample all germs at breaks are followed until their itineraries are known. These, and
with them the growth of laps, persist as long as the polynomials that decided them keep their signs:
the nearest roots of these bound an interval of constant entropy. If the orbits of both sides of a
break match, they are followed no further, and beside such an interval one proof may hold for
infinitely many others (:mod:`pwmap.longrun.entropy.matching`). Samples are taken in the widest gap
first. Intervals that touch are joined if their entropies agree, also at the number between them.

The entropy is zero where no piece expands: images of an interval are never longer than it, so that
for any N the first N steps cut a short enough interval at most once, and at most double its laps.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from math import prod

from sympy import QQ

from pwmap.algebra.arguments import checked_count, explained, shown
from pwmap.algebra.arithmetic import rational
from pwmap.algebra.exact import Number, dense, sign
from pwmap.algebra.numbers import to_double
from pwmap.algebra.roots import (
    Dense,
    Real,
    RealRoot,
    bounds,
    gap_around,
    real_to_sympy,
    roots_between,
    sign_at,
    simplest_between,
)
from pwmap.longrun.entropy.entropies import (
    ConstantEntropy,
    EntropyGap,
    EntropyIntervals,
    GapCause,
    exact_entropy,
)
from pwmap.longrun.entropy.kneading import STEPS, cofactors, growth_by_kneading, itinerary_of
from pwmap.longrun.entropy.matching import family_of, growth_of_pairs, matched
from pwmap.longrun.fates import Fate, Fates, GermOrbit
from pwmap.longrun.line import MapLine, line_at
from pwmap.maps.budget import BUDGET, Budget, BudgetError, Meter, metered
from pwmap.maps.piecewise_linear import PiecewiseLinearMap, check_map
from pwmap.maps.words import CriticalOrbit, Decision, MultiplierSign
from pwmap.parameters.cells import span_of_only

SAMPLES = 200  # values that are tried, by default
DEFAULT_GAPS = 4096  # gaps shorter than the span divided by this are left, by default
# Samples are tried at these fractions of a gap in turn, and up to the gap divided by NEARNESS away,
# for a simple rational.
SAMPLE_FRACTIONS = (1, 2), (2, 5), (4, 7), (3, 8)
NEARNESS = 12
DEGREE = 24  # of an algebraic number at which the entropy is still computed

Left = tuple[Real, Real, tuple[GapCause, ...]]  # a gap, and why nothing is proved on it


@dataclass(frozen=True, slots=True, eq=False)
class _Proved:
    """An open interval of constant entropy; ``closed`` says whether the proof holds at its ends."""

    low: Real
    high: Real
    closed: tuple[bool, bool]
    growth: Real
    sample: Number
    matches: bool


# the growth of laps at a place, at least 1; the decisions on which it depends; and whether both
# orbits of a break match
Proof = tuple[Real, tuple[Decision, ...], bool]


@explained()
def constant_entropy(
    map_: PiecewiseLinearMap,
    parameter: object,
    span: tuple[object, object],
    *,
    tolerance: object = None,
    samples: int = SAMPLES,
    steps: int = STEPS,
    budget: Budget | Meter = BUDGET,
) -> EntropyIntervals:
    """Intervals of a parameter on which the topological entropy is proved to be constant.

    Parameters
    ----------
    map_, parameter, span
        A map whose other parameters have values, the symbol or name of this one, and two rationals.
    tolerance
        A rational; gaps narrower than it are left. By default 1/4096 of the span.
    samples, steps
        How many values are tried, and for how many steps orbits of breaks are followed, at most.
    budget
        Where it ends, what is left of the span becomes gaps.

    Returns
    -------
    EntropyIntervals
        The intervals, each with the logarithm of an algebraic number, and the gaps between them.

    Raises
    ------
    ValueError
        If the map has other parameters or is an iterate, the span is no interval, or a number is
        not positive.

    Examples
    --------
    >>> from pwmap import PiecewiseLinearMap, constant_entropy
    >>> skew = PiecewiseLinearMap.from_sympy("Piecewise((x/2 + 1, x <= 0), (b*x + 1, True))")
    >>> found = constant_entropy(skew, "b", (-4, -1), samples=12)
    >>> [(each.lower, each.upper, each.entropy.value, each.cycles) for each in found.intervals]
    [(-4, -3, log(1/2 + sqrt(5)/2), ('LLR',)), (-2, -1, 0, ('LR',))]
    >>> [(gap.lower, gap.upper, [cause.name for cause in gap.causes]) for gap in found.gaps]
    [(-3, -2, ['OPEN'])]
    """
    check_map(map_)
    low, high = span_of_only(map_, parameter, span)
    least = (high - low) / DEFAULT_GAPS if tolerance is None else rational(tolerance)
    if not least > 0:
        raise ValueError(f"a tolerance must be positive, got {shown(tolerance)}")
    steps, samples = checked_count(steps, "steps"), checked_count(samples, "samples")
    study = _Study(map_, steps, metered(budget))
    proved, left = _swept(study, low, high, least, samples)
    return EntropyIntervals(
        parameter=map_.parameters[0],
        intervals=tuple(_joined(study, proved)),
        gaps=tuple(
            EntropyGap(lower=real_to_sympy(low), upper=real_to_sympy(high), causes=causes)
            for low, high, causes in _contiguous(left)
        ),
    )


class _Study:
    """A map over one parameter, and proofs of constant entropy at values of it."""

    def __init__(self, map_: PiecewiseLinearMap, steps: int, meter: Meter) -> None:
        self.map, self.orbits, self.steps, self.meter = map_, map_.orbits, steps, meter
        self.layout = map_.layout
        self.growth = cache(self._growth)  # of the instance, which a class's cache would keep

    def admits(self, place: Real) -> bool:
        region = self.map.definition.region
        return region.broken(lambda polynomial: sign_at(dense(polynomial), place)) is None

    def proof(self, line: MapLine) -> Proof | GapCause:
        """The growth of laps with the decisions on which it depends, or why it is not known."""
        if all(-1 <= branch.slope <= 1 for branch in line.branches):
            letters = set(self.layout.between)
            return QQ.one, tuple(MultiplierSign((k,), u) for k in letters for u in (1, -1)), False
        itineraries = self.itineraries(line)
        fates = {each.fate for each in itineraries}
        if Fate.OPEN in fates:
            expands = all(not -1 <= branch.slope <= 1 for branch in line.branches)
            return GapCause.EXPANDS if expands else GapCause.OPEN
        growth = growth_by_kneading(line, itineraries)
        if growth is None:
            return GapCause.LARGE
        decided: dict[Decision, None] = {MultiplierSign((k,), 0): None for k in self.layout.between}
        for number, itinerary in enumerate(itineraries):
            decided |= dict.fromkeys(self.decisions(line, number // 2, itinerary))
        return growth, tuple(decided), Fate.MATCHED in fates

    def itineraries(self, line: MapLine) -> list[GermOrbit]:
        """The itineraries of all germs, those of a break that match only up to that step."""
        found = list[GermOrbit]()
        for number in range(len(line.breaks)):
            found += self.matched(line, number) or (
                itinerary_of(line, germ, self.steps, self.meter)
                for germ in line.germs[2 * number : 2 * number + 2]
            )
        return found

    def proved_at_once(self, low: Real, high: Real) -> _Proved | None:
        """One proof for an interval on which the orbits of a single break change; None if none."""
        if isinstance(low, RealRoot) or isinstance(high, RealRoot):
            return None
        family = family_of(self.map, low, high)
        if family is None:
            return None
        sample = simplest_between(low, high)
        line = line_at(self.map, sample)
        itineraries = self.itineraries(line)
        changing = {
            number // 2
            for number, each in enumerate(itineraries)
            if each.fate is Fate.OPEN
            or not self.lasts(self.decisions(line, number // 2, each), low, high)
        }
        if len(changing) != 1:
            return None
        (number,) = changing
        weights = cofactors(line, itineraries, number)
        growth = growth_of_pairs(family, number, weights, self.meter)
        if growth is None:
            return None
        ends = self.admits(low), self.admits(high)
        return _Proved(low, high, ends, growth, sample, matches=False)

    def lasts(self, decisions: Iterable[Decision], low: Number, high: Number) -> bool:
        """Whether no decision changes on a closed interval."""
        return not any(
            not sign_at(each, low) or not sign_at(each, high) or roots_between(each, low, high)
            for each in self.polynomials(decisions)
        )

    def matched(self, line: MapLine, number: int) -> tuple[GermOrbit, GermOrbit] | None:
        """The itineraries of both sides of a break if they match identically in the parameter."""
        found = matched(line, number, self.steps, self.meter)
        if found is None:
            return None
        k = self.layout.breaks[number]
        one, other = (self.orbits.orbit(k, self.layout.word(each.numbers)) for each in found)
        return found if one == other else None

    def decisions(self, line: MapLine, number: int, itinerary: GermOrbit) -> Iterator[Decision]:
        """Yield the decisions, but for signs of slopes, on which a germ's itinerary depends."""
        k = self.layout.breaks[number]
        word = self.layout.word(itinerary.numbers)
        yield from self.layout.visits(k, itinerary.numbers)
        again = word[itinerary.start :]
        slope = prod(sign(line.branches[k].slope) for k in itinerary.word)
        match itinerary.fate:
            case Fate.FINITE | Fate.LOST:
                yield CriticalOrbit(k, word, k, word[: itinerary.start])
            case Fate.DRAWN if slope < 0:
                yield MultiplierSign(tuple(sorted(again)), -1)
            case Fate.DRAWN:
                yield MultiplierSign(tuple(sorted(again)), 1)
                for n, piece in enumerate(itinerary.word):
                    turned = again[n:] + again[:n]
                    yield from (CriticalOrbit(b, turned, b) for b in self.layout.around(piece))

    def polynomials(self, decisions: Iterable[Decision]) -> list[Dense]:
        """The polynomials of decisions, from the lowest degree on, without those that are zero."""
        every = (self.orbits.polynomial(decision) for decision in decisions)
        return sorted(dict.fromkeys(dense(each) for each in every if each), key=len)

    def _growth(self, place: Real) -> Real | None:
        """The growth of laps at one place; None if it is not known."""
        if isinstance(place, RealRoot) and len(place.polynomial) > DEGREE + 1:
            return None
        if not self.admits(place):
            return None
        try:
            found = self.proof(line_at(self.map, place))
        except BudgetError:  # the intervals proved so far are kept
            return None
        return None if isinstance(found, GapCause) else found[0]

    def proved(self, low: Real, high: Real, sample: Number) -> _Proved | GapCause:
        """The largest interval between two places on which the proof at a sample holds."""
        proof = self.proof(line_at(self.map, sample))
        if isinstance(proof, GapCause):
            return proof
        growth, decisions, matches = proof
        polynomials = self.polynomials(decisions)
        if any(not sign_at(each, sample) for each in polynomials):
            return GapCause.SPECIAL
        low, high = gap_around(sample, polynomials, low, high)

        def holds(end: Real) -> bool:
            return self.admits(end) and all(sign_at(each, end) for each in polynomials)

        ends = holds(low), holds(high)
        return _Proved(low, high, ends, growth, sample, matches)

    def cycles(self, sample: Number) -> list[str]:
        """The words of the cycles that attract orbits of breaks at a sample."""
        line = line_at(self.map, sample)
        fates = Fates(line, self.steps, Meter(BUDGET))
        for germ in line.germs:
            itinerary = itinerary_of(line, germ, self.steps, Meter(BUDGET))
            if itinerary.fate is Fate.DRAWN:
                fates.keep(fates.cycle_along([line.branches[k] for k in itinerary.word]))
            elif itinerary.fate is Fate.FLAT:
                fates.orbit(germ)
        return [cycle.word for cycle in sorted(fates.cycles, key=lambda each: each.points)]


def _swept(
    study: _Study, low: Number, high: Number, least: Number, samples: int
) -> tuple[list[_Proved], list[Left]]:
    """Proofs from samples in the widest gaps, sorted from left to right, and the gaps left over."""
    proved, left = list[_Proved](), list[Left]()
    gaps = list[tuple[float, Left]]()  # each after its width
    matching = set[Real]()  # ends of the intervals on which orbits of a break match
    taken = 0

    def keep(a: Real, b: Real, causes: tuple[GapCause, ...] = ()) -> None:
        width = _width(a, b)
        if width > least:
            gaps.append((to_double(width), (a, b, causes)))
        elif a != b:
            left.append((a, b, causes or (GapCause.NARROW,)))

    keep(low, high)
    while gaps:
        widest = max(range(len(gaps)), key=lambda k: gaps[k][0])
        a, b, causes = gaps.pop(widest)[1]
        found: _Proved | GapCause = _beside(study, matching, a, b, least) or GapCause.BUDGET
        for part in SAMPLE_FRACTIONS if found is GapCause.BUDGET else ():
            if taken >= samples or study.meter.stopped:
                break
            taken += 1
            sample = _near(a, b, part)
            with study.meter.keeping((sample,)):
                found = study.proved(a, b, sample)
                study.meter.advance("samples", taken, samples)
            if found is not GapCause.SPECIAL:
                break
        if isinstance(found, _Proved):
            proved.append(found)
            if found.matches:
                matching |= {found.low, found.high}
            keep(a, found.low)
            keep(found.high, b)
        elif found is GapCause.BUDGET:
            left.append((a, b, causes or (found,)))
        else:
            keep(a, sample, (found,))
            keep(sample, b, (found,))
    proved.sort(key=lambda each: each.sample)
    return proved, left


def _beside(
    study: _Study, matching: Container[Real], low: Real, high: Real, least: Number
) -> _Proved | None:
    """One proof for a part of a gap beside an interval of matching orbits; None if none."""
    for start, stop in ((low, high), (high, low)):
        if start in matching and not study.meter.stopped:
            with study.meter.keeping((start,)):
                found = _longest_proof(study, start, stop, least)
                if found is not None:
                    return found
    return None


def _longest_proof(study: _Study, start: Real, stop: Real, least: Number) -> _Proved | None:
    """The proof for the longest part of a gap from one end, found by bisection; or None."""

    def tried(end: Real) -> _Proved | None:
        return study.proved_at_once(*sorted((start, end)))

    ahead = 1 if start < stop else -1
    good, bad = _near(*sorted((start, bounds(start)[0] + ahead * least))), stop
    found = tried(good)
    if found is None:
        return None
    whole = tried(stop)
    while whole is None:
        ends = sorted((good, bad))
        last = _width(*ends) <= least
        end = simplest_between(*ends) if last else _near(*ends)
        longer = tried(end)
        if longer is None:
            bad = end
        else:
            found, good = longer, end
        if last:
            return found
    return whole


def _width(low: Real, high: Real) -> Number:
    return bounds(high)[1] - bounds(low)[0]


def _near(low: Real, high: Real, part: tuple[int, int] = (1, 2)) -> Number:
    """The simplest rational near a given part of an interval, by default its middle."""
    a, b = bounds(low)[1], bounds(high)[0]
    middle, off = a + (b - a) * QQ(*part), (b - a) / NEARNESS
    return simplest_between(middle - off, middle + off)


def _contiguous(left: Sequence[Left]) -> list[Left]:
    """The gaps from left to right; gaps that touch are joined."""
    found = list[Left]()
    for low, high, causes in sorted(left, key=lambda each: each[0]):
        if found and found[-1][1] == low:
            start, _, before = found.pop()
            low, causes = start, tuple(dict.fromkeys((*before, *causes)))
        found.append((low, high, causes))
    return found


def _joined(study: _Study, proved: Sequence[_Proved]) -> list[ConstantEntropy]:
    """The intervals; those that touch are joined if the entropy agrees at their common end, too."""
    runs = list[list[_Proved]]()
    for each in proved:
        last = runs[-1][-1] if runs else None
        if (
            last is not None
            and last.high == each.low
            and last.growth == each.growth
            and (last.closed[1] or each.closed[0] or study.growth(last.high) == last.growth)
        ):
            runs[-1].append(each)
        else:
            runs.append([each])
    return [_interval(study, run) for run in runs]


def _interval(study: _Study, run: Sequence[_Proved]) -> ConstantEntropy:
    first, last = run[0], run[-1]
    words = dict.fromkeys(word for each in run for word in study.cycles(each.sample))
    return ConstantEntropy(
        lower=real_to_sympy(first.low),
        upper=real_to_sympy(last.high),
        closed=(
            first.closed[0] or study.growth(first.low) == first.growth,
            last.closed[1] or study.growth(last.high) == last.growth,
        ),
        entropy=exact_entropy(first.growth, study.steps),
        samples=tuple(QQ.to_sympy(each.sample) for each in run),
        cycles=tuple(words),
    )
