"""Answers that follow from signs, kept along an axis until one of these signs changes.

An answer can change only at the roots of its decisions; it is computed anew beyond one of them. A
kinetic data structure calls such signs certificates, and their roots events [Basch1999].
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass
from typing import Any

from pwmap.maps.words import Decision, SignOracle
from pwmap.parameters.axis import Axis

Asked = tuple[Hashable, ...]  # a function of an oracle, and its other arguments


@dataclass(frozen=True, slots=True, eq=False)
class KeptAnswer:
    """What a function returned, and the signs that it asked for."""

    asked: Asked
    value: Any
    signs: dict[Decision, int]


class Answers:
    """Answers at one place of an axis after the other, kept while their signs persist."""

    def __init__(self, axis: Axis, low: Any, high: Any) -> None:
        self._axis = axis
        self._ends = low, high
        self._place: Any = None
        self._known: dict[Asked, KeptAnswer] = {}  # the kept answers that hold here
        self._used: dict[KeptAnswer, None] = {}  # those that were asked for here
        self._new: list[KeptAnswer] = []  # of these, the ones that were computed here
        self._roots: list[Any] = []  # of all decisions behind kept answers, from left to right
        self._deciding: dict[Any, list[Decision]] = {}  # the decisions that a root belongs to
        self._behind: dict[Decision, list[KeptAnswer]] = {}  # the answers that need a decision

    def move(self, place: Any, oracle: SignOracle) -> None:
        """Go to another place with its oracle; answers that may change on the way are dropped."""
        if self._place is not None:
            low, high = sorted((self._place, place))
            between = slice(bisect_left(self._roots, low), bisect_right(self._roots, high))
            for root in self._roots[between]:
                for decision in self._deciding[root]:
                    for answer in self._behind[decision]:
                        if self._known.get(answer.asked) is answer:
                            del self._known[answer.asked]
                    self._behind[decision] = []
        self._place, self._oracle = place, oracle
        self._used, self._new = {}, []

    def ask(self, question: Callable[..., Any], *about: Hashable) -> Any:
        """Return ``question(*about, oracle)`` at this place, kept or computed."""
        asked = question, *about
        found = self._known.get(asked)
        if found is None:
            oracle = SignOracle(self._oracle.orbits, self._oracle.sign_of)
            found = KeptAnswer(asked, question(*about, oracle), oracle.signs)
            self._new.append(found)
        self._used[found] = None
        return found.value

    def tell(self, oracle: SignOracle) -> None:
        """Give an oracle of this place the signs behind all answers that were used here."""
        for answer in self._used:
            oracle.signs.update(answer.signs)

    def zeros(self) -> Iterator[Decision]:
        """Decisions behind the new answers that are zero here."""
        return (d for answer in self._new for d, sign in answer.signs.items() if not sign)

    def keep(self) -> None:
        """Keep the new answers; call it only where this place is no root of their decisions."""
        for answer in self._new:
            self._known[answer.asked] = answer
            for decision in answer.signs:
                if decision not in self._behind:
                    self._behind[decision] = []
                    self._register(decision)
                self._behind[decision].append(answer)

    def _register(self, decision: Decision) -> None:
        """Note the roots of a decision within the ends."""
        low, high = self._ends
        for root in self._axis.roots(decision) or ():
            if not (root < low or high < root):
                if root not in self._deciding:
                    self._roots.insert(bisect_left(self._roots, root), root)
                    self._deciding[root] = []
                self._deciding[root].append(decision)

    def nearest(self, low: Any, high: Any) -> tuple[Any, Any]:
        """The nearest roots on both sides at which an answer here may change, or the ends."""
        roots = self._roots
        first, last = bisect_right(roots, low), bisect_left(roots, high)
        here = bisect_left(roots, self._place)
        return (
            next(filter(self._may_change, reversed(roots[first:here])), low),
            next(filter(self._may_change, roots[here:last]), high),
        )

    def _may_change(self, root: Any) -> bool:
        """Whether an answer that was used here may change at a root."""
        behind = (self._behind[decision] for decision in self._deciding[root])
        return any(answer in self._used for answers in behind for answer in answers)
