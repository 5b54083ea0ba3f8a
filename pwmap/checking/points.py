"""Special points of a diagram, and the statement on the whole of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pwmap.checking.branches import BANDS, FIXED, JUMPS, KINDS, ClaimedDiagram, ClaimedEnd
from pwmap.checking.iterates import CheckedIterate
from pwmap.checking.lists import COPIES, count
from pwmap.checking.polynomials import Number, derivative, primitive
from pwmap.checking.reading import canonical, fields, listed, number, shown, whole
from pwmap.checking.refusing import ROWS, STEP, digits, refuse


class Point:
    """A special point: all ends at one edge and one x; those of lowest order decide its kind."""

    def __init__(
        self, diagram: ClaimedDiagram, edge: int, ends: Sequence[ClaimedEnd], *, infinite: bool
    ) -> None:
        self.diagram, self.edge, self.ends, self.infinite = diagram, edge, ends, infinite
        self.place = diagram.places[2 * edge]
        self.order = min(end.stretch.order for end in ends if end.kind != JUMPS)
        self.own = [end for end in ends if end.stretch.order == self.order]
        self.fixed = [end for end in self.own if end.kind == FIXED]
        self.beside = [end for end in self.own if end.side]

    def claims(self) -> dict[str, Any]:
        """Kind, note, vanishing conditions, and the signs that tell a fold from persistence."""
        code, note = self._kind()
        conditions = [self._condition(end, code) for end in self.fixed if end.side]
        signs = self._signs() if code in ("BC", "FF") else None
        if signs is not None and (note == "fold") is not (signs[0] * signs[1] == -signs[2]):
            refuse(f"the signs {signs} do not make a {note} {self.diagram.where(2 * self.edge)}")
        return {"code": code, "note": note, "conditions": conditions, "signs": signs}

    def _unit(self, word: str) -> int:
        """The value 1 or -1 that the slope of a word takes here, unless it is constant; else 0."""
        map_ = self.diagram.map
        for unit in (1, -1):
            excess = map_.excess(word, -unit)
            if excess and self.place.sign(excess) == 0:
                return unit
        return 0

    def _kind(self) -> tuple[str, str]:
        units = {self._unit(end.stretch.word) for end in self.fixed}
        if self.infinite:
            if units != {1}:
                refuse(f"x has no bound without a slope 1 {self.diagram.where(2 * self.edge)}")
            return "LP", "x grows without bound"
        left, right = ({e.stretch.word for e in self.fixed if e.side == s} for s in (-1, 1))
        passing = left & right
        units = {self._unit(word) for word in passing}
        if -1 in units:
            doubled = any(e.kind == BANDS and e.stretch.order == 2 * self.order for e in self.ends)
            return "PD", "degenerate: points nearby have twice the period" * doubled
        if 1 in units or not self.fixed:
            return "LP", "degenerate: an interval of fixed points"
        stays = self.diagram.found(2 * self.edge, self.order)[FIXED]
        here = [end for end in self.fixed if end.stretch.word in stays]
        if staying := [end for end in here if end.stretch.word in passing]:
            return "BC", self._staying_note(staying)
        if len({end.side for end in self.beside}) != 1:
            alone = all(not end.side for end in self.fixed)
            return "BC", "isolated" if alone else "persistence"
        folding = [end for end in self.fixed if end.side]
        jumps = any(end.kind == JUMPS for end in self.own)
        steep = len(folding) == 1 and jumps and self._is_steep(folding[0])
        return ("FF" if steep else "BC"), "fold"

    def _staying_note(self, staying: Sequence[ClaimedEnd]) -> str:
        """The note on fixed points that stay on a border, and on what else ends there."""
        words = {end.stretch.word for end in staying}
        sides = {end.side for end in self.own if end.stretch.word not in words} - {0}
        notes = []
        if len({end.stretch.stable for end in staying}) > 1:
            notes.append("stability changes at the border")
        if sides:
            notes.append(
                f"{'fold' if len(sides) == 1 else 'persistence'} at a branch on the border"
            )
        elif not notes and any(end.kind == BANDS for end in self.own):
            notes.append("an interval of fixed points ends at a branch on the border")
        elif len(self.own) < len(self.ends):
            notes.append("higher orders end at a branch on the border")
        return ", ".join([*notes, *self._attraction()])

    def _attraction(self) -> list[str]:
        """A note if a fixed point attracts at this value only, or beside it only; else empty."""
        beside: dict[tuple[int, str], set[bool]] = {}
        for end in self.ends:
            if end.kind == FIXED and end.side:
                beside.setdefault(end.name[:2], set()).add(end.stretch.stable)
        for (order, word), stable in beside.items():
            here = self.diagram.found(2 * self.edge, order)[FIXED].get(word)
            if here is not None and stable == {not here.stable}:
                return ["attracts at this value only" if here.stable else
                        "does not attract at this value"]  # fmt: skip
        return []

    def _study(self, end: ClaimedEnd) -> CheckedIterate:
        return self.diagram.study(2 * self.edge + end.side, self.order)

    def _is_steep(self, end: ClaimedEnd) -> bool:
        """Whether the slope on the side of an end is larger than 1 in size."""
        study, word = self._study(end), end.stretch.word
        slope = end.stretch.quotients["slope"]
        return slope is not None and study.excess(word, 1) * study.excess(word, -1) < 0

    def _condition(self, end: ClaimedEnd, code: str) -> dict[str, Any]:
        """The polynomials that vanish at the end of a stretch, and whether the zeros are simple."""
        word = end.stretch.word
        if code in ("LP", "PD"):
            polynomials = [self.diagram.map.excess(word, 1 if code == "PD" else -1)]
        else:
            study = self._study(end)
            self.diagram.work.spend(STEP * len(study.atoms))
            rows = [row for row in study.beside if row[1].word == word and row[1].cut is None]
            polynomials = [
                study.above(border, value)
                for low, atom, high in rows
                for border, value in ((low, atom.left), (high, atom.right))
                if border is not None and value is not None
            ]
        sign = self.place.sign
        vanishing = [primitive(self.diagram.work, f) for f in polynomials if f and sign(f) == 0]
        simple = [sign(derivative(f)) != 0 for f in vanishing]
        vanishing_text = [[digits(c) for c in f] for f in vanishing]
        return {"word": word, "side": end.side, "vanishing": vanishing_text, "simple": simple}

    def _signs(self) -> list[int] | None:
        """The signs that decide between fold and persistence at a jump; None if not defined."""
        kinds = [end.kind == FIXED for end in self.beside]
        # side of the border, 1 - slope, other limit - x; not defined if more branches end there
        if sorted(kinds) != [False, True] or len(self.own) > 2:
            return None
        stretch = self.beside[kinds.index(True)].stretch
        words = self.beside[kinds.index(False)].stretch.word
        study = self.diagram.study(2 * self.edge, self.order)
        self.diagram.work.spend(STEP * len(study.atoms))
        for low, atom, high in study.beside:
            if atom.cut is None or low is None or high is None:
                continue
            if f"{low.word}|{high.word}" == words and stretch.word in words.split("|"):
                side = 1 if high.word == stretch.word else -1
                jump = study.side(atom, low.right if side > 0 else high.left)
                signs = [side, study.excess(stretch.word, -1), jump]
                return signs if all(signs) else None
        return None


def is_special(ends: Sequence[ClaimedEnd]) -> bool:
    """Whether fixed points end here, or pass through an interval that exists at the edge alone."""
    changing = any(not end.passes and end.kind != JUMPS for end in ends)
    return changing and any(end.kind == FIXED for end in ends)


def verified_points(diagram: ClaimedDiagram, rows: Sequence[object]) -> list[str]:
    """Verify the special points, and return texts that describe them."""
    inner = range(1, len(diagram.edges) - 1)
    left = {
        (i, end.name)
        for i in inner
        for end in diagram.ends(i)
        if end.kind == FIXED and not end.passes
    }
    listed_already: set[tuple[int, tuple[int, str, int]]] = set()
    texts = []
    for row in rows:
        names = ("edge", "x", "code", "note", "conditions", "signs")
        edge, at, *claims = fields(row, *names)
        i = whole(edge, 1, len(diagram.edges) - 2)
        side = {"oo": 1, "-oo": -1}.get(at) if isinstance(at, str) else None
        x = side or number(at, diagram.work)
        diagram.work.spend(STEP * len(diagram.ends(i)))
        ends = [end for end in diagram.ends(i) if diagram.is_at(end, i, x)]
        # each end of fixed points inside the span belongs to exactly one point
        fixed = {(i, end.name) for end in ends if end.kind == FIXED}
        where = f"{diagram.where(2 * i)} and x = {x.brief if isinstance(x, Number) else at}"
        if not is_special(ends) or fixed & listed_already:
            refuse(f"no fixed points end {where}, or they are listed twice")
        listed_already |= fixed
        left -= fixed
        true = Point(diagram, i, ends, infinite=side is not None).claims()
        if canonical(true) != canonical(dict(zip(names[2:], claims, strict=True))):
            refuse(f"the special point {where} is {shown(true)}, not {shown(row)}")
        simple = all(all(condition["simple"]) for condition in true["conditions"])
        parts = [true["code"], true["note"], "" if simple else "a zero that is not simple"]
        where = f"at {diagram.name} = {diagram.edges[i]} and x = {at if side else x}"
        texts.append(f"{', '.join(filter(None, parts))}, {where}")
        for _ in range(COPIES):
            diagram.work.keep(texts[-1])
    if left:
        i, name = min(left)
        refuse(f"fixed points {name[1]} end {diagram.where(2 * i)}, but no point is listed there")
    return texts


def diagram_statement(certificate: Mapping[str, Any]) -> str:
    """Verify the branches and special points over a parameter, and return the statement."""
    diagram = ClaimedDiagram(certificate)
    diagram.verify()
    texts = verified_points(diagram, listed(certificate["points"], ROWS))
    rows = {
        kind: count(sum(s.kind == kind for s in diagram.stretches), "stretch") for kind in KINDS
    }
    orders = ", ".join(map(str, diagram.orders))
    points = f"only at {count(len(texts), 'special point')}: {'; '.join(texts)}"
    return (
        f"For {diagram.map_text} and every {diagram.name} strictly between {diagram.edges[0]} and "
        f"{diagram.edges[-1]}, the lists hold all that the iterates P_j with j = {orders} have on "
        f"the diagonal: fixed points of least period j ({rows['fixed points']}, with x, slope and "
        f"stability), intervals of such points ({rows['intervals']}), and jumps with limits "
        f"strictly on both sides of it ({rows['crossings']}, with x and both limits); inside, "
        f"single fixed points begin and end {points if texts else 'nowhere'}."
    )
