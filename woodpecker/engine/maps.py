"""A piecewise-smooth map of R^d with k parameters: smooth pieces, each with margins that bound it.

A piece is a smooth map P(x, p) that exists beyond the set where the map takes it. Its margins
h_j(x, p) are positive inside, and one of them vanishes at a border. What the map takes
infinitesimally beyond a border is asked for at the border: :meth:`PiecewiseMap.beside`.

A map need not know its germs. What it takes beside a point is *proposed* by its images at small
distances, and *accepted* by the signs of margins and their derivatives at the point itself, so
that it does not depend on the distances: :func:`proposed`.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np
from scipy.optimize import brentq

from woodpecker.base.arrays import Bools, Floats, Ints

# A map's reason where it takes ever thinner pieces beside a point.
ACCUMULATE = "borders accumulate"
TIE = 2.0**-36  # a margin is zero if it is smaller than this part of its terms: a point on a
# border is known to some 2**-44 times the condition of the equations that it solves
STEEP_TIE = 2.0**-46  # the same of terms above 1, which say more of a slope than of a size: where
# an event time goes like a root all later margins have infinite slopes, and most are not zero

LARGE_SLOPE = 1e3  # of larger ones the rounding of a place on a border changes the image
CLOSER = 2.0**-33  # scaled: where slopes still have some digits left, and next to no curvature
CLOSEST = tuple(CLOSER * 4.0**-k for k in range(5))  # where roots are fitted, in turn
SMOOTH = 2.0**-18  # of slopes: those of a smooth piece differ by less at the distances above
DISTANCES = tuple(2.0**-n for n in (22, 28, 34, 40, 46, 16, 10))  # scaled, of proposals
NEAREST = min(DISTANCES)
# Scaled: where pieces that accumulate are seen, and at how many of these distances at least:
# rounding may decide at the least one.
THINNER, SEEN = tuple(2.0**-n for n in (33, 36, 39, 42, 46, 50)), 5
BEYOND = 2.0**8  # times what counts as a tie: so far from a point its piece of them may be at most
OWN = 4.0  # times what slopes make of a way: values farther off are of another solution
# How far exponents of roots and parts of distances are off by rounding at most, and which part of
# the change of a value a root may leave unexplained.
UNSURE = 2.0**-10
LEAST_POWER = 2.0**-4  # of a root: what grows slower is a logarithm, whose limit is none
SQUARE = 2.0**-12  # exponents closer to 1/2 are those of square roots


class SpaceImage(NamedTuple):
    """The image of a point under a piece."""

    value: Floats  # (d,) P(x, p)
    jacobian: Floats  # (d, d + k) derivatives in x and p
    margins: Floats  # (m,) h_j(x, p), positive where the map takes this piece
    gradients: Floats  # (m, d + k) derivatives of the margins
    codes: Ints  # (m,) ascending, of the margins; a piece need not have the same ones at two points
    piece: SpacePiece  # ready to be continued from this point
    reason: str = ""  # why there is no value; empty if there is one

    def tied(self, x: Floats, p: Floats, times: float = 1.0) -> Bools:
        """Which margins (m,) vanish at its point (x, p), but for rounding, or ``times`` of it."""
        size = np.abs(self.gradients) @ np.maximum(np.abs(np.concatenate([x, p])), 1.0)
        found: Bools = np.abs(self.margins) <= times * np.maximum(
            TIE * np.minimum(size, 1.0), STEEP_TIE * size
        )
        return found

    def begins_along(self, x: Floats, p: Floats, direction: Floats) -> bool:
        """Whether its piece is what the map takes infinitesimally beside (x, p) in a direction."""
        zero = self.tied(x, p)
        signs = np.where(zero, self.gradients @ direction, self.margins)
        return bool((signs > 0.0).all())

    @property
    def is_whole(self) -> bool:
        """Whether there is a value, with slopes."""
        return not self.reason and bool(np.isfinite(self.jacobian).all())

    @property
    def has_small_slopes(self) -> bool:
        """Whether there is a value, with slopes that are too small for the end of a root."""
        return not self.reason and bool(np.abs(self.jacobian).max() <= LARGE_SLOPE)

    def place(self, code: int) -> int:
        """Where the margin of a code stands; -1 if there is none here."""
        codes = self.codes.tolist()  # so few that a list is searched faster
        return codes.index(code) if code in codes else -1


class SpacePiece(Protocol):
    """A smooth map with margins. It may remember where it was met last, to start from there."""

    @property
    def key(self) -> Hashable:
        """Equal for two pieces just if they are one."""

    @property
    def word(self) -> str:
        """Its name, as people read it, such as a sequence of events."""

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """Its image of a point, also where the map takes another piece."""

    def cause(self, code: int) -> str:
        """A sentence on what happens where a margin vanishes."""


class SpaceMap(Protocol):
    """A map of R^d, made of pieces."""

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """The image of a point under the piece that the map takes there."""

    def beside(self, x: Floats, p: Floats, direction: Floats) -> SpaceImage:
        """The image under the piece that the map takes infinitesimally beside a point.

        The direction is (d + k,). Margins that vanish at the point count by the signs of their
        derivatives along it; no distance is looked at.
        """


def taken(map_: SpaceMap, x: Floats, p: Floats) -> tuple[Hashable, Floats]:
    """The key of the piece at a point, and its value (d,); a map may have its own method."""
    own = getattr(map_, "taken", None)
    if own is None:
        image = map_.at(x, p)
        return image.piece.key, image.value
    found: tuple[Hashable, Floats] = own(x, p)
    return found


def image_at(map_: SpaceMap, x: Floats, p: Floats) -> SpaceImage:
    """The image that a map takes at a point, or the reason why it has none.

    Where the map has a value, and only the path of its own piece is lost, borders accumulate.
    """
    image = map_.at(x, p)
    if image.reason and not np.isnan(taken(map_, x, p)[1]).any():
        return image._replace(reason=ACCUMULATE)
    return image


def margins_decide(map_: SpaceMap) -> bool:
    """Whether a map is sure that it takes a piece just where all of its margins are positive."""
    return getattr(map_, "margins_decide", False)


def proposed(
    map_: SpaceMap, x: Floats, p: Floats, direction: Floats, scale: Sequence[float]
) -> SpaceImage:
    """The image of a point (d,) under the piece infinitesimally beside it, or a reason why none.

    The map has no value right beside the point, or its pieces accumulate there. ``scale`` holds the
    d lengths of x and those of the k parameters.
    """
    length, d = float(np.abs(direction / np.array(scale)).max()), len(x)
    if length == 0.0:
        return map_.at(x, p)._replace(reason=ACCUMULATE)
    unit, seen = direction / length, set[Hashable]()
    lost, around = "", None
    for distance in DISTANCES:
        proposal = image_at(map_, x + distance * unit[:d], p + distance * unit[d:])
        if distance == NEAREST:
            lost = proposal.reason
        if proposal.reason or proposal.piece.key in seen:
            continue
        seen.add(proposal.piece.key)
        image = limit(proposal, x, p, unit)
        if image.reason or not image.begins_along(x, p, unit):
            continue
        if image.tied(x, p).any():
            return image
        around = around or image  # its border is elsewhere: a thinner piece may begin here
    return around or map_.at(x, p)._replace(reason=lost or ACCUMULATE)


@dataclass(frozen=True, slots=True)
class Accumulating:
    """One of the ever thinner pieces that accumulate at a border, for their common limit there.

    Of the margins that bound it beside that border it has one only, which vanishes all along it.
    """

    own: SpacePiece
    code: int  # of that margin
    dropped: frozenset[int]  # codes of the others

    @property
    def key(self) -> Hashable:
        """That of the piece."""
        return self.own.key

    @property
    def word(self) -> str:
        """That of the piece."""
        return self.own.word

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """Its image of a point on the border; none where the pieces there are thinner by far."""
        image = self.own.at(x, p)
        if image.reason:
            return image
        codes = image.codes.tolist()
        kept = np.array([code not in self.dropped for code in codes])
        bounds = np.array([code == self.code for code in codes])
        if not ((kept & ~bounds) | image.tied(x, p, BEYOND)).all():
            return image._replace(reason=ACCUMULATE)
        return image._replace(
            margins=np.where(bounds, 0.0, image.margins)[kept], gradients=image.gradients[kept],
            codes=image.codes[kept], piece=replace(self, own=image.piece),
        )  # fmt: skip

    def cause(self, code: int) -> str:
        """That of the piece."""
        return self.own.cause(code)


def accumulated(
    map_: SpaceMap, x: Floats, p: Floats, direction: Floats, lengths: Floats
) -> SpaceImage | None:
    """The limit at (x, p) of the pieces that accumulate there in a direction; None if none is seen.

    Where impacts become ever more, in ever shorter time, paths differ and their images do not.
    """
    unit, d, found = direction / np.abs(direction / lengths).max(), len(x), list[SpaceImage]()
    for distance in THINNER:
        near = map_.at(x + distance * unit[:d], p + distance * unit[d:])
        image = near if near.reason else near.piece.at(x, p)
        if image.reason or not all(_tends_to(each, image, unit) for each in found):
            break
        found.append(image)
    if len(found) < SEEN or found[0].piece.key == found[-1].piece.key:
        return None
    last = found[-1]
    bounds = last.tied(x, p, BEYOND) | (last.margins <= 0.0)
    inward = bounds & (last.gradients @ unit > 0.0)
    if not inward.any():
        return None
    code = int(last.codes[np.where(inward, np.abs(last.margins), math.inf).argmin()])
    dropped = frozenset(last.codes[bounds].tolist()) - {code}
    image = Accumulating(last.piece, code, dropped).at(x, p)
    return None if image.reason else image


def _tends_to(image: SpaceImage, last: SpaceImage, unit: Floats) -> bool:
    """Whether two pieces that accumulate at a point differ there by as much as their widths say."""
    change = np.abs(image.jacobian @ unit) + np.abs(last.jacobian @ unit) + np.abs(last.value)
    near = np.abs(last.value - image.value) <= OWN * THINNER[0] * change
    return bool(near.all())


def limit(near: SpaceImage, x: Floats, p: Floats, unit: Floats) -> SpaceImage:
    """The one-sided limit at (x, p) of the piece of an image that lies a little away."""
    # Where the piece has no value at the point, or derivatives there are rounding, those beside it
    # are taken. At a root they grow without bound: three of them tell its power and its limit.
    there = near.piece.at(x, p)
    if not there.reason and _alike(there.jacobian, near.jacobian, SMOOTH):
        return there
    away, d = CLOSER * unit, len(x)
    closer = near.piece.at(x + away[:d], p + away[d:])
    if closer.reason:
        return closer
    if not there.reason and _comes_to(near.jacobian, closer.jacobian, there.jacobian):
        return there
    along = closer.jacobian @ away
    value = closer.value - along
    root = root_of(near.piece, x, p, unit)
    if root is not None:
        value = root.value
    elif not there.reason and np.abs(there.value - value).max() <= OWN * np.abs(along).max():
        value = there.value  # where two solutions of an event meet it may be that of the other one
    return closer._replace(value=value, margins=closer.margins - closer.gradients @ away)


class RootEnd(NamedTuple):
    """A root in which a piece ends: a + b h^s + c h at a distance h from its border."""

    value: Floats  # (d,) a
    exponent: float  # s
    growth: Floats  # (d,) of slopes away from the border, towards it: the signs of b


def root_of(piece: SpacePiece, x: Floats, p: Floats, unit: Floats) -> RootEnd | None:
    """The root in which a piece ends at (x, p), along a direction; None if in none."""
    # The closer it is looked at the less next terms count, until slopes are rounding.
    best, least = None, UNSURE
    for distance in CLOSEST:
        found, off = _fitted(piece, x, p, unit, distance)
        if found is None or (best is not None and off >= least):
            break
        if off < least:
            best, least = found, off
        if off <= SMOOTH:
            break  # no better one is needed
    return best


def _fitted(
    piece: SpacePiece, x: Floats, p: Floats, unit: Floats, closest: float
) -> tuple[RootEnd | None, float]:
    """The root in which a piece ends, fitted from a distance on, and its error."""
    # Its value and its power s, 0 < s < 1, follow from slopes at three distances, each about four
    # times the one before, and values at two. The error is that of the third value, relative to its
    # difference from the first. The power is that of the steepest component.
    away, d = [4.0**k * closest for k in range(3)], len(x)
    images = [piece.at(x + h * unit[:d], p + h * unit[d:]) for h in away]
    if any(image.reason for image in images):
        return None, math.inf
    h = _distances(images, unit, away)
    slopes = np.array([image.jacobian @ unit for image in images])
    every = slopes[:-1] - slopes[1:]  # without c
    most = int(np.abs(every[0]).argmax())  # of the components, which have one power
    bends: list[float] = every[:, most].tolist()
    if not (bends[0] * bends[1] > 0.0 and abs(bends[0]) > SMOOTH * abs(slopes[0, most])):
        return None, math.inf
    about = 1.0 - math.log(bends[0] / bends[1]) / math.log(4.0)

    def unequal(s: float) -> float:
        powers = [math.pow(each / h[1], s - 1.0) for each in h]
        return (powers[0] - powers[1]) * bends[1] - (powers[1] - powers[2]) * bends[0]

    low, high = about - UNSURE, about + UNSURE
    if not LEAST_POWER < low < high < 1.0 or not unequal(low) * unequal(high) < 0.0:
        return None, math.inf
    s = float(brentq(unequal, low, high))
    s = 0.5 if abs(s - 0.5) <= SQUARE else s
    # With B = b h^s and C = c h there are the values a + B + C, a + t^s B + t C, and s B + C.
    t, steep = h[1] / h[0], slopes[0] * h[0]
    part = (t**s - t * s) / (1.0 - s)
    near, far, farthest = (image.value for image in images)
    value = (far - part * near - (t - part) * steep) / (1.0 - part)
    t, b = h[2] / h[0], (near - value - steep) / (1.0 - s)
    rest = float(np.abs(farthest - (value + t**s * b + t * (steep - s * b))).max())
    way = float(np.abs(farthest - near).max())  # none if all of it is rounding
    return RootEnd(value, s, every[0]), rest / way if way > 0.0 else math.inf


def _distances(images: Sequence[SpaceImage], unit: Floats, away: list[float]) -> list[float]:
    """Distances of images of a piece from the border by the margin that vanishes there."""
    # Points so close to it are rounded, and that margin is rounded as the values are.
    rates = images[0].gradients @ unit
    (ahead,) = np.nonzero((rates > 0.0) & (images[0].margins > 0.0))
    if not len(ahead):
        return away
    code = int(images[0].codes[ahead[(images[0].margins[ahead] / rates[ahead]).argmin()]])
    found = list[float]()
    for image in images:
        k = image.place(code)
        rate = float(image.gradients[k] @ unit) if k >= 0 else 0.0
        found.append(float(image.margins[k]) / rate if rate else math.nan)
    near = all(abs(a - b) <= UNSURE * b for a, b in zip(found, away, strict=True))
    return found if near else away


def _comes_to(one: Floats, closer: Floats, there: Floats) -> bool:
    """Whether derivatives at a point are the limit of those ever closer to it."""
    return bool(np.abs(closer - there).max() <= 0.5 * np.abs(one - there).max())


def _alike(one: Floats, other: Floats, within: float) -> bool:
    size = max(1.0, float(np.abs(one).max()), float(np.abs(other).max()))
    return bool(np.abs(one - other).max() <= within * size)


@dataclass(frozen=True, slots=True)
class Chain:
    """Several pieces in turn, as one; its margins, all of theirs, depend on the first point."""

    pieces: tuple[SpacePiece, ...]  # at least one

    @property
    def key(self) -> Hashable:
        """The keys of the pieces."""
        return tuple(piece.key for piece in self.pieces)

    @property
    def word(self) -> str:
        """Their words."""
        return " | ".join(piece.word for piece in self.pieces)

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """The last image, with all margins and derivatives in the first point."""
        images, value = [], x
        for piece in self.pieces:
            images.append(piece.at(value, p))
            if images[-1].reason:
                return images[-1]
            value = images[-1].value
        return chained(images)

    def cause(self, code: int) -> str:
        """The sentence of the piece that has the margin."""
        rest, i = divmod(code, len(self.pieces))
        return self.pieces[i].cause(rest)


def chained(images: Sequence[SpaceImage]) -> SpaceImage:
    """Several images in turn as one: the last, with derivatives in the first point."""
    if len(images) == 1:
        return images[0]
    (d, columns), n = images[0].jacobian.shape, len(images)
    inner = np.eye(d, columns)  # derivatives of the point that is reached, in (x, p)
    margins, gradients, codes = [], [], []
    for i, image in enumerate(images):
        margins.append(image.margins)
        gradients.append(_through(image.gradients, inner, d))
        codes.append(n * image.codes + i)
        inner = _through(image.jacobian, inner, d)
    order = np.argsort(np.concatenate(codes), kind="stable")
    return SpaceImage(
        images[-1].value, inner, np.concatenate(margins)[order], np.concatenate(gradients)[order],
        np.concatenate(codes)[order], Chain(tuple(image.piece for image in images)),
    )  # fmt: skip


def length_of(image: SpaceImage) -> int:
    """How many pieces an image went through."""
    return len(image.piece.pieces) if isinstance(image.piece, Chain) else 1


def first_link(image: SpaceImage) -> SpacePiece:
    """The piece under an image, the first if it is a chain, with all of its margins."""
    piece = image.piece.pieces[0] if isinstance(image.piece, Chain) else image.piece
    return piece.own if isinstance(piece, Accumulating) else piece


def links(image: SpaceImage, x: Floats, p: Floats) -> list[SpaceImage]:
    """The images that a chain is made of, in turn; of a single piece its own."""
    if not isinstance(image.piece, Chain):
        return [image]
    found = list[SpaceImage]()
    for piece in image.piece.pieces:
        found.append(piece.at(found[-1].value if found else x, p))
    return found


def _through(outer: Floats, inner: Floats, d: int) -> Floats:
    """Derivatives (m, d + k) of functions of a point, as functions of one that leads to it."""
    found: Floats = outer[:, :d] @ inner
    found[:, d:] += outer[:, d:]
    return found
