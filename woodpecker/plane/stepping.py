"""Steps along a curve, and what happens on the way."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from pwmap.diagrams.diagram import PointStatus
from pwmap.plane.kinds import PlaneKind
from woodpecker.base.arrays import Floats
from woodpecker.piecewise.margins import IN_X, lowest_dip
from woodpecker.piecewise.orbits import SPACING, Margin
from woodpecker.piecewise.pieces import Image, judge
from woodpecker.piecewise.samples import angle
from woodpecker.plane.nodes import Node, Test, is_inside, is_tiny, margins_along, node_at, tests_of
from woodpecker.plane.places import (
    Along,
    Equation,
    Locus,
    Place,
    Plane,
    Unknown,
    held,
    replaced,
    solve,
    tangent,
)

SPAN, WINDOW = "end of the span", "end of the window"
CLOSED, SHORT, MANY = "the curve closes", "steps become too short", "as many samples as allowed"
TRIED = "as many steps tried as allowed"
TOO_CLOSE = "closer to a border than rounding tells"

ADVANCES = 400  # along a border, most of them in vain where slopes right at it are those of a root


class UnclearError(Exception):
    """A shorter step is needed to tell what lies between two nodes."""


@dataclass(frozen=True, slots=True, eq=False)
class Event:
    """Something that happens along a curve.

    Attributes
    ----------
    kind
        What it is; None for a border, of which the map has to say.
    node
        Where.
    distance
        From the node before, in scaled unknowns.
    cause
        A sentence.
    margin
        The margin that vanishes.
    ends
        Whether the curve ends here.
    test
        Which function vanishes: it is not looked at in the next step.
    status
        Whether it was located.
    """

    kind: PlaneKind | None
    node: Node
    distance: float
    cause: str = ""
    margin: Margin | None = None
    ends: bool = False
    test: Test | None = None
    status: PointStatus = PointStatus.LOCATED


class Stepper:
    """Follows one curve as long as its pieces do not change."""

    def __init__(self, plane: Plane, locus: Locus, n: int) -> None:
        self.plane, self.locus, self.settings = plane, locus, plane.first
        self.numerics = plane.first.numerics
        self.tests, self.scale = tests_of(plane, locus, n), plane.scales(n)
        self.equations = locus.equations(plane)
        self._closed = self.settings.jump * self.settings.x_scale

    # --- One step -----------------------------------------------------------------------------

    def node(self, place: Place, like: Floats) -> Node | None:
        """A place as a sample whose tangent points like another one; None if it has none."""
        along = tangent(self.plane, place, self.locus)
        if not np.isfinite(along).all():
            return None
        same = bool(along @ like >= 0.0)
        found = node_at(self.plane, self.locus, place, along if same else -along)
        return replace(found, along=same) if isinstance(self.locus.held, float) else found

    def advance(self, last: Node, step: float, before: Node | None = None) -> Node | float:
        """The node one step ahead, or a shorter step to try."""
        predicted = self._predicted(last, step, before)
        ahead = Along(last.place.point, last.tangent, step, self.scale)
        found = None
        for guess in (self._beside_border(last, before, predicted, ahead), predicted):
            if guess is None or not guess.defined:
                continue
            solution = solve(self.plane, guess, [*self.equations, ahead], contracts=True)
            found = self.node(solution.place, last.tangent) if solution.converged else None
            if found is not None:
                break
        if found is None or _turned_back(last, found):
            return 0.5 * step
        turned, most = angle(last.tangent, found.tangent), self.settings.max_turn
        if turned > most:
            return max(self.numerics.retry, self.numerics.kept_turn * most / turned) * step
        return found

    def _beside_border(
        self, last: Node, before: Node | None, predicted: Place, ahead: Along
    ) -> Place | None:
        """Where a curve may go on that leads along a border; None if it does not.

        Beside a root folds and flips lie so close to a border that a step would cross it. There its
        margin is predicted, by a power of what it was, instead of the point.
        """
        near = self._nearest(last)
        if not (isinstance(self.locus.held, float) and predicted.defined) or near is None:
            return None
        margin, away = near
        if not 0.0 < away < self.numerics.hugs * ahead.distance:
            return None
        value = last.orbit.images[margin.index].margin(margin.code)
        if before is not None and before.orbit.keys == last.orbit.keys:
            once = before.orbit.images[margin.index].margin(margin.code)
            part = ahead.distance / self._length(before, last)
            if once > 0.0 and math.isfinite(part):
                value *= min(max((value / once) ** part, 0.5), 2.0)
        cycle, *_ = self.equations
        kept = held(replace(margin, value=value), self.plane)
        found = solve(self.plane, predicted, [cycle, kept, ahead], anchor=last.place)
        return found.place if found.converged else None

    def to_end(self, last: Node, step: float) -> Node | None:
        """The node at the end of a span, if a step leads there: beyond, there may be no map."""
        for axis in (0, 1):
            index, value = axis - 2, last.place.values[axis]
            along = float(last.tangent[index] * self.scale[index])
            low, high = self.plane.settings[axis].span
            end = high if along > 0.0 else low
            if along == 0.0 or not abs(end - value) < step * abs(along) or value == end:
                continue
            predicted = self._predicted(last, (end - value) / along)
            if not predicted.defined:
                continue
            solution = solve(self.plane, predicted, [*self.equations, Unknown(index, end)])
            found = self.node(solution.place, last.tangent) if solution.converged else None
            if found is not None and angle(last.tangent, found.tangent) <= self.settings.max_turn:
                return found
        return None

    def _predicted(self, last: Node, step: float, before: Node | None = None) -> Place:
        move = step * last.tangent
        if before is not None:
            chord = (last.place.point - before.place.point) / self.scale
            length = float(np.linalg.norm(chord))
            if length > 0.0:
                mean, part = chord / length, step / length
                third = last.tangent + before.tangent - 2.0 * mean
                square = 2.0 * last.tangent + before.tangent - 3.0 * mean
                move = move + step * part * (square + part * third)
        return self.plane.moved(last.place, move * self.scale)

    def between(self, a: Node, b: Node, part: float) -> Place:
        """The place at a part of the way between two nodes, on the cubic through both."""
        chord = (b.place.point - a.place.point) / self.scale
        length = float(np.linalg.norm(chord))
        first, last = length * a.tangent, length * b.tangent
        third, square = first + last - 2.0 * chord, 3.0 * chord - 2.0 * first - last
        move = part * (first + part * (square + part * third))
        return self.plane.moved(a.place, move * self.scale)

    # --- What happens in a step ---------------------------------------------------------------

    def event(
        self, a: Node, b: Node, step: float, skipped: Test | None, origin: Node | None
    ) -> Event | None:
        """The first event between two nodes; UnclearError if a shorter step is needed to tell."""
        found = [*self._borders(a, b, step), *self._ends(a, b, step)]
        for test in self.tests:
            if test is not skipped:
                found += self._tested(a, b, step, test)
        if origin is not None:
            found += self._closing(a, b, origin)
        first = min(found, key=lambda each: each.distance, default=None)
        if first is None:
            if not self._agrees(b.place):
                raise UnclearError
            return None
        return first

    def _tested(self, a: Node, b: Node, step: float, test: Test) -> list[Event]:
        before, after = test.value(a), test.value(b)
        if test.kind is PlaneKind.JUMP_CLOSES and max(abs(before), abs(after)) <= self._closed:
            return []  # nothing is left of it but rounding
        if not (before * after < 0.0 or (after == 0.0 and before != 0.0)):
            return []
        found: dict[float, Node] = {}

        def value(distance: float) -> float:
            node = a if distance == 0.0 else self.advance(a, distance)
            if isinstance(node, float):
                raise UnclearError
            found[distance] = node
            return test.value(node)

        try:
            root = float(brentq(value, 0.0, self._length(a, b), xtol=SPACING * max(step, SPACING)))
        except ValueError:
            raise UnclearError from None
        nearest = min(found, key=lambda distance: abs(distance - root))
        if 2.0 * abs(test.value(found[nearest])) > min(abs(before), abs(after)):
            return []  # it jumps there
        return [Event(test.kind, found[nearest], nearest, ends=test.ends, test=test)]

    def across(self, last: Node) -> tuple[Node, str] | None:
        """The first node beyond the nearest border, and what happens there; None if none is found.

        Beside a root in the map folds and flips come to a border like a tangent, with a contact of
        third order, and steps towards it become ever shorter. So the border is followed until the
        piece beyond it has a fold or a flip next to it.
        """
        near = self._nearest(last)
        if not isinstance(self.locus.held, float) or near is None:
            return None
        margin, _ = near
        on_border = Stepper(self.plane, Locus(margin), len(last.place))
        here = Along(last.place.point, last.tangent, 0.0, self.scale)
        solution = solve(self.plane, last.place, [*on_border.equations, here])
        node = on_border.node(solution.place, last.tangent) if solution.converged else None
        step, way = self.settings.again, 0.0
        for _ in range(ADVANCES):
            if node is None or way > self.settings.max_step or step < self.settings.min_step:
                break
            ahead = on_border.advance(node, step)
            if isinstance(ahead, float):
                step = ahead
                continue
            node, way, step = ahead, way + step, 2.0 * step
            found = self._beyond(last, node, margin.index)
            if found is not None:
                return found, node.orbit.images[margin.index].piece.cause(margin.code)
        return None

    def too_short(self, last: Node) -> str:
        """Why steps have become too short at a node."""
        near = self._nearest(last)
        own = isinstance(self.locus.held, float)
        return TOO_CLOSE if own and near is not None and near[1] <= self.settings.same else SHORT

    def _beyond(self, last: Node, on_border: Node, index: int) -> Node | None:
        """The node with the piece beyond a border, as far from the last one as a place on it."""
        border = on_border.border
        if border is None or border.outer.reason:
            return None
        start = replaced(self.plane, on_border.place, index, border.outer.piece)
        length = self._length(last, on_border)
        ahead = Along(last.place.point, last.tangent, length, self.scale)
        aside, away = np.zeros(len(self.scale)), self.numerics.nearer * length
        aside[index] = border.side * self.scale[index]
        while away >= self.settings.nearest:
            guess = self.plane.moved(start, away * aside)
            away *= self.numerics.nearer
            if not guess.defined:
                continue
            solution = solve(self.plane, guess, [*self.equations, ahead], contracts=True)
            node = self.node(solution.place, last.tangent) if solution.converged else None
            near = node is not None and angle(last.tangent, node.tangent) <= self.settings.max_turn
            if near and node is not None and self._agrees(node.place):
                return node
        return None

    def _nearest(self, node: Node) -> tuple[Margin, float] | None:
        """The margin nearest to vanishing, and how far away that is in scaled unknowns."""
        found = dict[Margin, float]()
        for i, image in enumerate(node.orbit.images):
            size = np.linalg.norm(node.place.gradients(i) * self.plane.scales(1), axis=1)
            for code, margin, most in zip(image.causes, image.margins, size, strict=True):
                if most > 0.0:
                    found[Margin(i, int(code))] = abs(float(margin)) / float(most)
        return min(found.items(), key=lambda item: item[1], default=None)

    def _ends(self, a: Node, b: Node, step: float) -> Iterator[Event]:
        own = self.locus.held.index if isinstance(self.locus.held, Unknown) else -1
        bounds = [(WINDOW, i, self.settings.window) for i in range(len(a.place)) if i != own]
        bounds += [(SPAN, axis - 2, self.plane.settings[axis].span) for axis in (0, 1)]
        for cause, index, (low, high) in bounds:
            one, other = float(a.place.point[index]), float(b.place.point[index])
            for end, outward in ((low, -1.0), (high, 1.0)):
                if not outward * (other - end) >= 0.0 > outward * (one - end):
                    continue
                if other == end:
                    node, distance = b, self._length(a, b)
                else:
                    part = (end - one) / (other - one)
                    node, distance = self._solved(a, b, part, Unknown(index, end), step)
                named = cause if index >= 0 else f"{cause} of {self.plane.family.names[index + 2]}"
                yield Event(PlaneKind.END, node, distance, named, ends=True)

    def _borders(self, a: Node, b: Node, step: float) -> Iterator[Event]:
        """Where the first margin vanishes, but for the one that does all along the curve."""
        crossed = list(self._crossed(a, b))
        if not crossed:
            self._look_for_dips(a, b, step)
            return
        margin, part = min(crossed, key=lambda each: each[1])
        node, distance = self._solved(a, b, part, held(margin, self.plane), step)
        if not is_inside(self.plane, self.locus, node.place, margin) or self._rises(node, margin):
            raise UnclearError  # another one vanishes before, or this one does
        cause = node.orbit.images[margin.index].piece.cause(margin.code)
        yield Event(None, node, distance, cause, margin)

    def _rises(self, node: Node, margin: Margin) -> bool:
        """Whether a margin becomes larger along the curve."""
        _, rates = margins_along(self.plane, node, margin.index)
        codes = node.orbit.images[margin.index].causes
        return bool((rates[codes == margin.code] > 0.0).any())

    def _crossed(self, a: Node, b: Node) -> Iterator[tuple[Margin, float]]:
        for i, (one, other) in enumerate(zip(a.orbit.images, b.orbit.images, strict=True)):
            for code in other.causes[other.margins < 0.0].tolist():
                margin = Margin(i, code)
                together = all(is_tiny(self.plane, node.place, i, code) for node in (a, b))
                if margin == self.locus.border or together:
                    continue
                before, after = one.margin(code), other.margin(code)
                if not before > 0.0:
                    raise UnclearError
                yield margin, before / (before - after)

    def _look_for_dips(self, a: Node, b: Node, step: float) -> None:
        """UnclearError if a margin may have been negative between two nodes."""
        length = self._length(a, b)
        for i in range(len(a.place)):
            one, other = (self._along(node, i) for node in (a, b))
            part = lowest_dip(one, other, length, IN_X, IN_X, self.numerics)
            if part is None or step <= self.numerics.blurred:
                continue
            middle = self.advance(a, part * length)
            if isinstance(middle, float) or any(True for _ in self._crossed(a, middle)):
                raise UnclearError

    def _along(self, node: Node, i: int) -> Image:
        """The image of a point, its margins as functions of the way along the curve."""
        margins, rates = margins_along(self.plane, node, i)
        image = node.orbit.images[i]
        clear = np.isfinite(rates)
        for k, code in enumerate(image.causes.tolist()):
            own = Margin(i, code) == self.locus.border
            clear[k] &= not (own or is_tiny(self.plane, node.place, i, code))
        flat = np.column_stack([rates, np.zeros_like(rates)])
        return image._replace(
            margins=margins[clear], gradients=flat[clear], causes=image.causes[clear]
        )

    def _solved(
        self, a: Node, b: Node, part: float, equation: Equation, step: float
    ) -> tuple[Node, float]:
        """The node that obeys one more equation, and how far away; UnclearError if none does."""
        guess = self.between(a, b, min(1.0, max(0.0, part)))
        start = guess if guess.defined else a.place
        solution = solve(self.plane, start, [*self.equations, equation])
        away = (solution.place.point - a.place.point) / self.scale
        distance, slack = float(a.tangent @ away), self.numerics.slack
        most = step * (1.0 + slack) + self.settings.same
        near = float(np.linalg.norm(away)) <= 2.0 * step + self.settings.same
        if not (solution.converged and near and -self.settings.same <= distance <= most):
            raise UnclearError
        node = self.node(solution.place, a.tangent)
        if node is None:
            node = node_at(self.plane, self.locus, solution.place, a.tangent)
        return node, distance

    def _closing(self, a: Node, b: Node, origin: Node) -> list[Event]:
        if b.orbit.keys != origin.orbit.keys:
            return []
        one, other = ((each.place.point - origin.place.point) / self.scale for each in (a, b))
        length = float(np.linalg.norm(other - one))
        before, after = float(origin.tangent @ one), float(origin.tangent @ other)
        if not (before < 0.0 <= after and np.linalg.norm(one) <= 2.0 * length):
            return []
        off = one + (other - one) * (before / (before - after))
        if np.linalg.norm(off) > self.settings.max_turn * length:
            return []
        return [Event(PlaneKind.END, origin, -float(a.tangent @ one), CLOSED, ends=True)]

    def _agrees(self, place: Place) -> bool:
        """Whether the map takes the pieces of a place, but for that on a border."""
        border, taken = self.locus.border, judge(self.plane.map(place.values))
        return all(
            taken(float(x), place.values[0])[0] == image.piece.key
            for i, (x, image) in enumerate(zip(place.orbit.x, place.orbit.images, strict=True))
            if border is None or i != border.index
        )

    def _length(self, a: Node, b: Node) -> float:
        return float(a.tangent @ ((b.place.point - a.place.point) / self.scale))


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """Nodes along which no piece changes, and what happens there.

    Attributes
    ----------
    nodes
        From the start to the end.
    events
        Through which it passes, each with the number of its node.
    end
        What ends it.
    step
        The last step.
    beyond
        The first node beyond a border that is met like a tangent.
    """

    nodes: tuple[Node, ...]
    events: tuple[tuple[int, Event], ...]
    end: Event
    step: float
    beyond: Node | None = None


@dataclass(slots=True)
class Steps:
    """How many steps may still be tried along a curve."""

    left: int


def follow(
    stepper: Stepper, start: Node, steps: Steps, first: float = math.inf,
    origin: Node | None = None, skipped: Test | None = None,
) -> Arc:  # fmt: skip
    """Follow a curve from a node to the first border that a cycle meets, or to its end."""
    settings, nodes, events = stepper.settings, [start], list[tuple[int, Event]]()
    step, grows, event = min(first, settings.step), True, None
    looked = settings.numerics.blurred  # shorter steps may lead to a border like a tangent
    leaving = _leaves(stepper, start)
    if leaving is not None:
        return Arc((start,), (), leaving, step)
    while len(nodes) < settings.max_samples and steps.left > 0:
        steps.left -= 1
        if step < settings.min_step:
            event = given_up(nodes[-1], stepper.too_short(nodes[-1]))
            return Arc(tuple(nodes), tuple(events), event, step)
        last = nodes[-1]
        smooth = len(nodes) > 1 and (not events or events[-1][0] < len(nodes) - 1)
        before = nodes[-2] if smooth else None
        found = stepper.to_end(last, step) or stepper.advance(last, step, before)
        if isinstance(found, float):
            step, grows = found, False
            if step < looked:
                looked = settings.numerics.split * step
                beyond = stepper.across(last)
                if beyond is not None:
                    node, cause = beyond
                    event = Event(None, last, 0.0, cause)
                    return Arc(tuple(nodes), tuple(events), event, step, node)
            continue
        try:
            event = stepper.event(last, found, step, skipped, origin if len(nodes) > 1 else None)
        except UnclearError:
            step, grows = 0.5 * step, False
            continue
        skipped = None
        nodes.append(found if event is None else event.node)
        if event is not None and (event.ends or event.margin is not None):
            return Arc(tuple(nodes), tuple(events), event, step)
        if event is not None:
            events.append((len(nodes) - 1, event))
            skipped = event.test
            continue
        turned = angle(last.tangent, found.tangent) / settings.max_turn
        wanted, growth = settings.numerics.kept_turn, 2.0 if grows else 1.0
        growth = wanted / turned if growth * turned > wanted else growth
        step, grows = min(settings.max_step, step * growth), True
    why = MANY if steps.left > 0 else TRIED
    return Arc(tuple(nodes), tuple(events), given_up(nodes[-1], why), step)


def _turned_back(last: Node, found: Node) -> bool:
    """Whether a step led onto the other arm of a needle, where the curve goes the other way."""
    return last.along is not None and found.along is not None and last.along is not found.along


def given_up(node: Node, cause: str) -> Event:
    """The open end of a curve that is left here."""
    return Event(PlaneKind.END, node, 0.0, cause, ends=True, status=PointStatus.OPEN)


def _leaves(stepper: Stepper, start: Node) -> Event | None:
    """Whether a node lies at the end of a span, and the curve leaves it there."""
    for axis in (0, 1):
        value, along = start.place.values[axis], start.tangent[axis - 2]
        low, high = stepper.plane.settings[axis].span
        if (value <= low and along < 0.0) or (value >= high and along > 0.0):
            cause = f"{SPAN} of {stepper.plane.family.names[axis]}"
            return Event(PlaneKind.END, start, 0.0, cause, ends=True)
    return None


def turned_round(node: Node) -> Node:
    """The same the other way."""
    along = None if node.along is None else not node.along
    return replace(node, tangent=-node.tangent, along=along)
