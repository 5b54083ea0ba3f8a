"""Certificates of the toy, verified from scratch: :func:`check_certificate`."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Mapping, Sequence
from decimal import ROUND_CEILING, Decimal
from decimal import Context as Decimals
from fractions import Fraction
from itertools import zip_longest
from operator import gt
from pathlib import Path
from typing import Any

from woodpecker.checking.forms import Box, F, constant
from woodpecker.checking.intervals import Extent, I, NotSeparated, T, unit
from woodpecker.checking.motion import Choice, Guard, Tracker
from woodpecker.checking.toy import NAMES, PAPER, ExactToy

FORMAT, VERSION = "certificate of the Woodpecker Toy", 1
NUMBER = re.compile(r"-?[0-9]{1,2000}(\.[0-9]{1,2000})?(/[0-9]{1,2000})?")
GUARD = re.compile(r"(gap|normal|cone\+|cone-|slip|plateau\+|plateau-) ([123])|section")
LONGEST = 50_000_000  # characters of a file
MOST = 400  # events of a return
LATEST = 10  # s: no phase of a return lasts longer, and ranges over longer ones say nothing
DEPTH = 3  # halvings of a piece's line
RESTITUTIONS = ("eps_n1", "eps_n2", "eps_n3")
Interval = tuple[Fraction, Fraction]


NOT_MADE_SO = (
    ArithmeticError, AttributeError, IndexError, KeyError, MemoryError, RecursionError, TypeError,
    ValueError,
)  # fmt: skip
"""What reading something else than a certificate comes to."""


class Rejected(ValueError):  # noqa: N818  (what a checker says)
    """A certificate that does not hold; the sentence says why."""


def check_certificate(path: str | os.PathLike[str]) -> str:
    """Verify a certificate of the toy, and say what is proved.

    Parameters
    ----------
    path
        A file as :meth:`woodpecker.proofs.certificates.Certificate.save` writes it.

    Returns
    -------
    str
        The statement, composed from what was verified.

    Raises
    ------
    Refused
        If the certificate does not hold, or is none.
    OSError
        If the file cannot be read.
    """
    raw = Path(path).read_bytes()
    if len(raw) > LONGEST:
        raise Rejected(f"a certificate has at most {LONGEST} characters, got {len(raw)}")
    try:
        content = json.loads(raw.decode("ascii"), object_pairs_hook=_object)
    except UnicodeDecodeError:
        raise Rejected("this is no certificate: it holds characters that none has") from None
    except (ValueError, RecursionError) as error:
        raise Rejected(f"this is no certificate: {error}") from None
    return check(content)


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    if len({key for key, _ in pairs}) != len(pairs):
        raise ValueError("a key is there twice")
    return dict(pairs)


def check(content: Any) -> str:
    """The same for the content of a file."""
    try:
        return _checked(content)
    except NotSeparated as error:
        raise Rejected(f"the certificate does not hold: {error}") from None
    except Rejected:
        raise
    except NOT_MADE_SO as error:
        raise Rejected(f"the certificate is not made as one is: {error!a:.200}") from None


def _checked(content: Any) -> str:
    if not isinstance(content, dict):
        raise Rejected("a certificate is an object with named entries")
    if content.get("format") != FORMAT or content.get("version") != VERSION:
        raise Rejected(f"the format must be {FORMAT!r}, version {VERSION}")
    rest = {key: value for key, value in content.items() if key != "seal"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    if content.get("seal") != hashlib.sha256(text.encode("ascii")).hexdigest():
        raise Rejected("the seal is broken: something was changed after the proof was written")
    kinds = {"orbit": _orbit, "branch": _branch, "point": _point}
    if content["kind"] not in kinds:
        raise Rejected(f"kind must be one of {', '.join(kinds)}, got {content['kind']!r}")
    digits = content["digits"]
    if not isinstance(digits, int) or not 20 <= digits <= 200:
        raise Rejected(f"digits must be a whole number from 20 to 200, got {digits!r}")
    expected = {"format", "version", "kind", "statement", "digits", "toy", "law", "parameter"}
    with unit(int(digits * 3.33) + 30):
        statement, keys = kinds[content["kind"]](content, _Data(content))
    if set(content) != expected | {"order", "seal"} | keys:
        raise Rejected("the certificate has other entries than its kind needs")
    if statement != content["statement"]:
        raise Rejected("the statement is another one than what is proved")
    return statement


def number(text: Any) -> Fraction:
    """A rational number from text."""
    if not isinstance(text, str) or not NUMBER.fullmatch(text):
        raise Rejected(f"a number must be text such as -0.25 or 1/3, got {text!a:.60}")
    top, _, bottom = text.partition("/")
    return Fraction(top) / Fraction(bottom) if bottom else Fraction(top)


def interval(pair: Any) -> Interval:
    """An interval from two texts."""
    if not isinstance(pair, list) or len(pair) != 2:
        raise Rejected(f"an interval must have two ends, got {pair!a:.60}")
    low, high = number(pair[0]), number(pair[1])
    if low > high:
        raise Rejected(f"an interval must not end before it begins, got {pair}")
    return low, high


def claimed(name: str, found: I, pair: Any) -> None:
    """Refuse a claim that does not hold what was found."""
    low, high = interval(pair)
    if not (low <= found.ends[0] and found.ends[1] <= high):
        raise Rejected(f"{name} could not be shown to lie in {pair}")


class _Data:
    """The toy of a certificate, and what moves."""

    def __init__(self, content: Mapping[str, Any]) -> None:
        toy, self.parameter, law = content["toy"], content["parameter"], content["law"]
        if set(toy) != set(NAMES) or law not in ("summed", "separate"):
            raise Rejected("the toy must have all its numbers and a law, summed or separate")
        self.moves = content["kind"] != "orbit"
        if self.moves and (self.parameter not in RESTITUTIONS or toy[self.parameter] is not None):
            raise Rejected("only a restitution coefficient may move, and has no value then")
        if self.parameter not in toy:
            raise Rejected(f"the toy has no parameter {self.parameter!r}")
        values = {name: number(x) for name, x in toy.items() if x is not None}
        if len(values) != len(toy) - self.moves:
            raise Rejected("a number of the toy is missing")
        if not all(0 <= values[name] <= 1 for name in RESTITUTIONS if name in values):
            raise Rejected("restitution must lie in [0, 1]")
        if any(x <= 0 for name, x in values.items() if name[:3] not in ("eps", "mu_")):
            raise Rejected("masses, lengths and stiffness must be positive")
        if any(x < 0 for x in values.values()) or values["r_m"] <= values["r_0"]:
            raise Rejected("the toy cannot have these numbers")
        self.values, self.order, self.law, self.texts = values, content["order"], law, toy
        self.toy = ExactToy(values, law == "summed")
        if not isinstance(self.order, int) or not 1 <= self.order <= 100:
            raise Rejected(f"order must be a whole number from 1 to 100, got {self.order!r}")

    def follower(self, box: Box, line: Sequence[Fraction], curve: Sequence[Fraction]) -> Tracker:
        """The toy on the section, at rest."""
        eps: list[F | I] = [I.of(self.values.get(name, 0)) for name in RESTITUTIONS]
        if self.moves:
            eps[RESTITUTIONS.index(self.parameter)] = _polynomial(box, line, False)
            ends = eps[RESTITUTIONS.index(self.parameter)]
            assert isinstance(ends, F)
            if not ends.value.inside(I.of(0, 1)):
                raise Rejected("restitution must lie in [0, 1]")
        none = constant(box, I.of(0))
        x = _polynomial(box, curve, True)
        if not x.value.less(I.of(self.toy.touch[0])):
            raise NotSeparated("the beak may touch the pole at the start")
        q = [none, constant(box, I.of(self.toy.touch[1])), x]
        return Tracker(self.toy, box, eps, q, [none, none, none])


def _polynomial(box: Box, c: Sequence[Fraction], start: bool) -> F:
    """A polynomial in tau, plus s where it is the start."""
    rate = [k * c[k] for k in range(1, len(c))] or [Fraction(0)]
    bend = [k * rate[k] for k in range(1, len(rate))] or [Fraction(0)]
    parts = [c, [Fraction(int(start))], rate, [Fraction(0)], [Fraction(0)], bend]
    return F(box, [T.of(box.span, part) for part in parts[: box.depth]])


class _Return:
    """A return along one way, verified."""

    def __init__(
        self, data: _Data, box: Box, line: Any, curve: Any, way: Mapping[str, Any]
    ) -> None:
        if set(way) != {"word", "events"} or not 1 <= len(way["events"]) <= MOST:
            raise Rejected("a way has a word and events")
        events: list[tuple[Guard, I]] = []
        for event in way["events"]:
            if not isinstance(event, list) or len(event) != 3:
                raise Rejected(
                    f"an event is a guard and two ends of its duration, got {event!a:.60}"
                )
            name, low, high = event
            if not isinstance(name, str) or not GUARD.fullmatch(name):
                raise Rejected(f"there is no guard {name!a:.40}")
            kind, _, contact = name.partition(" ")
            guard = (kind, int(contact) - 1 if contact else 0)
            bracket = interval([low, high])
            if max(map(abs, bracket)) > LATEST:
                raise Rejected(f"a phase lasts at most {LATEST} s, got {low:.40} to {high:.40}")
            events.append((guard, I.of(*bracket)))
        motion = data.follower(box, line, curve)
        motion.run(events)
        if " ".join(motion.word) != way["word"]:
            raise Rejected(f"the word is {' '.join(motion.word)}, not {way['word']}")
        assert motion.time is not None
        self.image, self.drop = motion.q[2], -motion.q[0]
        self.period, self.forks = motion.time, motion.forks


def _both(returns: Sequence[_Return], kinds: Sequence[str]) -> None:
    """Refuse two ways that are not the two sides of one decision; or one way with a fork."""
    if len(returns) == 1 and not returns[0].forks:
        return
    if len(returns) != 2 or any(len(each.forks) != 1 for each in returns):
        raise NotSeparated("a decision is open, and its two ways are not there")
    forks: list[Choice] = [fork for each in returns for fork in each.forks]
    if any(fork.kind not in kinds for fork in forks):
        raise NotSeparated("a decision is open, and its two ways are not there")
    first, second = forks
    meets = first.kind == "meeting"
    same = first.kind == second.kind and first.at == second.at
    same = same and first.contacts == (second.contacts[::-1] if meets else second.contacts)
    if not same or (not meets and first.leaves == second.leaves):
        raise NotSeparated("the two ways are not those of one decision")


class _VerifiedPiece:
    """A piece, verified: exactly one cycle in the tubes for every parameter on the line."""

    def __init__(self, data: _Data, piece: Mapping[str, Any], terms: int, turns: bool) -> None:
        if set(piece) != {"line", "half", "points"} or len(piece["points"]) != data.order:
            raise Rejected("a piece has a line, half of its length, and a point for each return")
        self.line = [number(c) for c in piece["line"]]
        self.half, points = number(piece["half"]), piece["points"]
        span = Extent(self.half, terms)
        if self.half < 0 or not self.line or len(self.line) > 40:
            raise Rejected("a line has one to forty coefficients and a length")
        if not data.moves and (self.half != 0 or self.line != [data.values[data.parameter]]):
            raise Rejected("the parameter is not that of the toy")
        if data.moves and self.half == 0:
            raise Rejected("a piece of a branch has a length")
        if self.half > 0 and _rising(self.line, span) is False:
            raise NotSeparated("the parameter may turn round")
        self.curves = [[number(c) for c in point["curve"]] for point in points]
        self.radii = [number(point["radius"]) for point in points]
        if any(set(point) != {"curve", "radius", "ways"} for point in points):
            raise Rejected("a point has a curve, a radius and ways")
        if any(r <= 0 for r in self.radii) or any(not c or len(c) > 40 for c in self.curves):
            raise Rejected("a tube has a curve and a positive radius")
        _apart(self.curves, self.radii, span)
        misses, slopes, self.returns = [], [], []
        for k, point in enumerate(points):
            box = Box(I.of(self.radii[k]), span, 6 if turns else 2)
            found = [_Return(data, box, self.line, self.curves[k], way) for way in point["ways"]]
            _both(found, ("rest", "plateau"))
            aim = _polynomial(box, self.curves[(k + 1) % len(points)], False)
            misses.append(_hull([(r.image.parts[0] - aim.parts[0]).range for r in found]))
            slopes.append(_hull([r.image.part((1, 0)) for r in found]))
            self.returns.append(found)
        self.off = _around(misses, slopes)
        if not all(s.within(I.of(r).ball) for s, r in zip(self.off, self.radii, strict=True)):
            raise NotSeparated("no cycle could be shown to lie in the tubes")
        self.multiplier = _product(slopes)
        self.turn = self._turn(slopes) if turns else None

    def _turn(self, slopes: list[I]) -> I:
        """Range of the derivative of the multiplier in tau along the cycle."""
        n, misses = len(slopes), []
        images = [found[0].image for found in self.returns]
        if any(len(found) > 1 for found in self.returns):
            raise NotSeparated("a word changes where a flip is claimed")
        for k, image in enumerate(images):
            aim = _polynomial(image.box, self.curves[(k + 1) % n], False)
            misses.append((image.parts[2] - aim.parts[2]).range)
        moves, total = _around(misses, slopes), I.of(0)
        for k, image in enumerate(images):
            own = image.part((1, 1)) + image.part((2, 0)) * moves[k]
            total = total + own * _product(slopes[:k] + slopes[k + 1 :])
        return total

    def parameter(self, side: int) -> Fraction:
        """The value of the parameter at an end."""
        return _value(self.line, side * self.half)

    def place(self, side: int, k: int) -> tuple[Interval, Interval]:
        """At an end: the tube of a point, and where the point is."""
        at, radius = _value(self.curves[k], side * self.half), self.radii[k]
        return (at - radius, at + radius), (I.of(at) + self.off[k]).ends


class _Halves:
    """A piece that was verified in two halves of its line, with the same tubes: so as a whole."""

    def __init__(self, low: _Verified, high: _Verified) -> None:
        self.low, self.high = low, high
        self.multiplier: I = low.multiplier.hull(high.multiplier)
        self.turn: I | None = None
        if low.turn is not None and high.turn is not None:
            self.turn = low.turn.hull(high.turn)

    def parameter(self, side: int) -> Fraction:
        """The value of the parameter at an end."""
        return (self.low if side < 0 else self.high).parameter(side)

    def place(self, side: int, k: int) -> tuple[Interval, Interval]:
        """At an end: the tube of a point, and where the point is."""
        return (self.low if side < 0 else self.high).place(side, k)


_Verified = _VerifiedPiece | _Halves


def _verified(
    data: _Data, piece: Mapping[str, Any], terms: int, turns: bool, claim: Any, depth: int = 0
) -> _Verified:
    """A piece, as a whole or in parts of its line, over which ranges are sharper."""
    half = number(piece["half"])
    last = depth == DEPTH or half <= 0
    try:
        whole = _VerifiedPiece(data, piece, terms, turns)
    except NotSeparated:
        if last:
            raise
    else:
        if last or whole.multiplier.inside(I.of(*interval(claim))):
            return whole
    parts = []
    for side in (-1, 1):
        points = [
            {**point, "curve": _moved(point["curve"], side * half / 2)} for point in piece["points"]
        ]
        line = _moved(piece["line"], side * half / 2)
        part = {"line": line, "half": str(half / 2), "points": points}
        parts.append(_verified(data, part, terms, turns, claim, depth + 1))
    return _Halves(*parts)


def _moved(texts: Sequence[str], by: Fraction) -> list[str]:
    """Coefficients of a polynomial about another centre."""
    c = [number(text) for text in texts]
    for k in range(len(c) - 1):
        for j in range(len(c) - 2, k - 1, -1):
            c[j] += by * c[j + 1]
    return [str(x) for x in c]


def _apart(curves: Sequence[Sequence[Fraction]], radii: Sequence[Fraction], span: Extent) -> None:
    """Refuse tubes in which a cycle might be a shorter one that is passed several times."""
    n = len(curves)

    def meet(i: int, k: int) -> bool:
        both = zip_longest(curves[i], curves[k], fillvalue=Fraction(0))
        distance = T.of(span, [a - b for a, b in both]).range
        wide = I.of(radii[i] + radii[k])
        return (distance - wide).sign() != 1 and (distance + wide).sign() != -1

    for period in range(1, n):
        if n % period == 0 and all(meet(k, (k + period) % n) for k in range(n)):
            raise NotSeparated(f"the cycle may be one of {period}, passed several times")


def _rising(line: Sequence[Fraction], span: Extent) -> bool:
    return T.of(span, [k * line[k] for k in range(1, len(line))]).range.sign() == 1


def _value(c: Sequence[Fraction], x: Fraction) -> Fraction:
    total = Fraction(0)
    for each in reversed(c):
        total = total * x + each
    return total


def _hull(parts: Sequence[I]) -> I:
    whole = parts[0]
    for part in parts[1:]:
        whole = whole.hull(part)
    return whole


def _product(parts: Sequence[I]) -> I:
    total = I.of(1)
    for part in parts:
        total = total * part
    return total


def _around(e: Sequence[I], slopes: Sequence[I]) -> list[I]:
    """Solve s_(k+1) = e_k + slope_k s_k around a cycle."""
    n, whole = len(e), I.of(1) - _product(slopes)
    found = []
    for i in range(n):
        total = I.of(0)
        for k in range(i, i + n):
            total = e[k % n] + slopes[k % n] * total
        found.append(total / whole)
    return found


def _stable(multiplier: I) -> bool | None:
    if multiplier.size.less(I.of(1)):
        return True
    beyond = (multiplier - I.of(1)).sign() == 1 or (multiplier + I.of(1)).sign() == -1
    return False if beyond else None


def _orbit(content: Mapping[str, Any], data: _Data) -> tuple[str, set[str]]:
    outer = _VerifiedPiece(data, content["outer"], 1, False)
    inner = _VerifiedPiece(data, content["inner"], 1, False)
    if inner.curves != outer.curves or any(map(gt, inner.radii, outer.radii)):
        raise Rejected("the inner box does not lie in the middle of the outer one")
    claimed("the multiplier", inner.multiplier, content["multiplier"])
    period, drop = I.of(0), I.of(0)
    for ways in inner.returns:
        period = period + _hull([way.period.value for way in ways])
        drop = drop + _hull([way.drop.value for way in ways])
    claimed("the period", period, content["period"])
    claimed("the drop", drop, content["drop"])
    if content["stable"] is not _stable(I.of(*interval(content["multiplier"]))):
        raise Rejected("stability is another one than the multiplier says")
    stable = {True: "it is stable", False: "it is unstable", None: "its stability is open"}
    what = "fixed point" if data.order == 1 else f"cycle of {data.order} points"
    points = content["inner"]["points"]
    where = ", ".join(f"{p['curve'][0]} within {p['radius']}" for p in points)
    radius = ", ".join(p["radius"] for p in content["outer"]["points"])
    words = " | ".join(" or ".join(way["word"] for way in p["ways"]) for p in points)
    name = data.parameter
    return (
        f"{_head(data)} {name} = {content['toy'][name]} has exactly one {what} of the return map "
        f"with phi_S at most {radius} from these places: {where}. Its word is {words}, its "
        f"multiplier lies in {_ends(content['multiplier'])}, so {stable[content['stable']]}; its "
        f"period lies in {_ends(content['period'])} s, its drop in {_ends(content['drop'])} m."
    ), {"outer", "inner", "multiplier", "period", "drop", "stable"}


def _head(data: _Data) -> str:
    named = {data.parameter, *(name for name in NAMES if data.values.get(name) == PAPER[name])}
    others = [f"{name} = {data.texts[name]}" for name in NAMES if name not in named]
    law = "; ".join([f"expansion friction {data.law}", *others])
    return f"The Woodpecker Toy ({law}) with"


def _ends(pair: Sequence[str]) -> str:
    return f"[{pair[0]}, {pair[1]}]"


def _branch(content: Mapping[str, Any], data: _Data) -> tuple[str, set[str]]:
    terms, flips, texts = content["terms"], content["flips"], content["pieces"]
    if not isinstance(terms, int) or not 1 <= terms <= 30:
        raise Rejected(f"terms must be a whole number from 1 to 30, got {terms!r}")
    if not texts or not len(texts) == len(content["multiplier"]) == len(content["stable"]):
        raise Rejected("each piece has a multiplier and a claim on stability")
    places = [k for k in range(len(texts)) if k in flips]
    if not isinstance(flips, list) or flips != places or any(type(k) is not int for k in flips):
        raise Rejected("flips are numbers of pieces, each once, in ascending order")
    gaps = [interval(gap) for gap in content["gaps"]]
    open_, before, sides, joints = list(gaps), None, [], []
    for k, text in enumerate(texts):
        claim = content["multiplier"][k]
        piece = _verified(data, text, terms, k in flips, claim)
        claimed(f"the multiplier of piece {k}", piece.multiplier, claim)
        if content["stable"][k] is not _stable(I.of(*interval(content["multiplier"][k]))):
            raise Rejected("stability is another one than the multiplier says")
        if k not in flips:
            side = (piece.multiplier + I.of(1)).sign()
            if not side:
                raise NotSeparated("the multiplier may pass -1 outside the flips")
            sides.append(side)
        elif piece.turn is None or not piece.turn.sign():
            raise NotSeparated("the multiplier may not be monotone at a flip")
        else:
            sides.append(0)
        if before is not None:
            joints.append(before.parameter(1) == piece.parameter(-1))
            if joints[-1]:
                _joined(before, piece, data.order)
            elif not open_ or open_.pop(0) != (before.parameter(1), piece.parameter(-1)):
                raise Rejected("pieces do not join, and no gap says so")
        before = piece
    _flips_pass(sides, joints)
    if open_:
        raise Rejected("a gap lies between no pieces")
    low, high = interval(content["span"])
    line, half = texts[0]["line"], number(texts[0]["half"])
    assert before is not None
    if (low, high) != (_value([number(c) for c in line], -half), before.parameter(1)):
        raise Rejected("the pieces do not cover the span")
    what = "one fixed point" if data.order == 1 else f"one cycle of {data.order} points"
    count = {0: "no flip", 1: "exactly one flip"}.get(len(flips), f"exactly {len(flips)} flips")
    return (
        f"{_head(data)} {data.parameter} in {_ends(content['span'])} has, in each of {len(texts)} "
        f"tubes, exactly {what} of the return map for each value: {_hangs_together(gaps)}, with "
        f"{count}."
    ), {"terms", "pieces", "multiplier", "stable", "flips", "gaps", "span"}


def _hangs_together(gaps: Sequence[Interval]) -> str:
    """How pieces between gaps belong together."""
    if not gaps:
        return "one branch, for the tubes join, without a gap"
    total = sum((high - low for low, high in gaps), Fraction(0))
    above = Decimals(prec=2, rounding=ROUND_CEILING)
    length = above.divide(Decimal(total.numerator), Decimal(total.denominator))
    many = "intervals" if len(gaps) > 1 else "interval"
    return (
        f"{len(gaps) + 1} stretches of tubes that join, and between them {len(gaps)} {many}, of a "
        f"total length of at most {length}, in which nothing is said, nor whether the stretches "
        "belong together"
    )


def _joined(before: _Verified, piece: _Verified, order: int) -> None:
    """The cycle of one piece lies in the tubes of the other where they meet."""
    for outer, a, inner, b in ((before, 1, piece, -1), (piece, -1, before, 1)):
        places = [(outer.place(a, k)[0], inner.place(b, k)[1]) for k in range(order)]
        if all(low < x and y < high for (low, high), (x, y) in places):
            return
    raise NotSeparated("two pieces may hold different cycles where they meet")


def _flips_pass(sides: Sequence[int], joints: Sequence[bool]) -> None:
    """Where a flip is claimed the multiplier is on different sides of -1 before and after."""
    for k, joins in enumerate(joints):
        if joins and sides[k] * sides[k + 1] == -1:
            raise NotSeparated("the multiplier passes -1 between two pieces")
    for k, side in enumerate(sides):
        if side == 0 and not (
            0 < k < len(sides) - 1
            and joints[k - 1]
            and joints[k]
            and sides[k - 1] * sides[k + 1] == -1
        ):
            raise NotSeparated("the multiplier does not pass -1 where a flip is claimed")


def _point(content: Mapping[str, Any], data: _Data) -> tuple[str, set[str]]:
    centre, ways, own = content["centre"], content["ways"], content["own"]
    if (
        set(centre) != {"x", "p", "radius"}
        or len(ways) != 2
        or own not in (0, 1)
        or data.order != 1
    ):
        raise Rejected("a point has a centre, two ways and says which one is its own")
    x, p, radius = number(centre["x"]), number(centre["p"]), number(centre["radius"])
    if radius <= 0:
        raise Rejected("a box has a positive radius")
    box = Box(I.of(radius), Extent(radius, 2), 3)
    returns = [_Return(data, box, [p, Fraction(1)], [x], way) for way in ways]
    _both(returns, ("meeting",))
    image, border = returns[own].image, returns[0].forks[0].comparator
    moved = _krawczyk(image, border, x, radius)
    found_x, found_p = I.of(x) + moved[0], I.of(p) + moved[1]
    claimed("phi_S", found_x, content["x"])
    claimed("the parameter", found_p, content["p"])
    limit = returns[1 - own].image.value
    claimed("the other limit", limit, content["limit"])
    for k in range(2):
        claimed("a slope", returns[k].image.part((1, 0)), content["slopes"][k])
    along = border.part((1, 0)).sign()
    slope = image.part((1, 0))
    moves = -(border.part((0, 1)) / border.part((1, 0)))
    speed = slope * moves + image.part((0, 1)) - moves
    gap, stays = (limit - found_x).sign(), (I.of(1) - slope).sign()
    steep = -1 if slope.size.less(I.of(1)) else (1 if _stable(slope) is False else 0)
    if not (along and gap and stays and steep and speed.sign()):
        raise NotSeparated("the kind of the point is open")
    side = along if own == 0 else -along
    fold = side * stays == -gap
    code, note = ("FF" if fold and steep == 1 else "BC"), ("fold" if fold else "persistence")
    if (content["side"], content["code"], content["note"]) != (side, code, note):
        raise Rejected(f"the point is {code}, {note}, on side {side}")
    name = {"FF": "fold-flip", "BC": "border collision"}[code]
    mine, other = ways[own]["word"], ways[1 - own]["word"]
    return (
        f"{_head(data)} {data.parameter} in {_ends(content['p'])} has a {name} ({code}, {note}) at "
        f"phi_S in {_ends(content['x'])}: the fixed point of the word {mine}, which is taken "
        f"{'above' if side > 0 else 'below'} the border, meets the jump to the word {other}, whose "
        f"limit lies in {_ends(content['limit'])}; the slopes there lie in "
        f"{_ends(content['slopes'][own])} and {_ends(content['slopes'][1 - own])}."
    ), {"centre", "ways", "own", "x", "p", "limit", "slopes", "side", "code", "note"}


def _krawczyk(image: F, border: F, x: Fraction, radius: Fraction) -> tuple[I, I]:
    """Where image = x and border = 0 hold, about the centre of a box: once, inside the box."""
    first = [f.parts[0].first + I(-f.parts[0].rest, f.parts[0].rest) for f in (image, border)]
    first[0] = first[0] - I.of(x)
    jacobian = [
        [image.part((1, 0)) - I.of(1), image.part((0, 1))],
        [border.part((1, 0)), border.part((0, 1))],
    ]
    (a, b), (c, d) = ([entry.mid for entry in row] for row in jacobian)
    determinant = (a * d - b * c).mid
    inverse = [[d / determinant, -(b / determinant)], [-(c / determinant), a / determinant]]
    ball, found = I.of(radius).ball, []
    for i in range(2):
        total = -(inverse[i][0] * first[0] + inverse[i][1] * first[1])
        for j in range(2):
            rest = I.of(1) if i == j else I.of(0)
            for k in range(2):
                rest = rest - inverse[i][k] * jacobian[k][j]
            total = total + rest * ball
        if not total.within(ball):
            raise NotSeparated("the point could not be shown to lie in the box")
        found.append(total)
    return found[0], found[1]
