"""Piecewise-smooth maps of R^d with k parameters: smooth pieces, each bounded by margins.

A piece is a smooth map P(x, p), defined also beyond the region where the map takes it. Its margins
h_j(x, p) are positive inside that region, and one of them vanishes at each border. The *germ* of
the map, the piece taken infinitesimally beside a point, is given by :meth:`SpaceMap.beside`.

If only images are known, those at small distances *propose* a piece, and the signs of its margins
and of their derivatives at the point itself *accept* it or not, so that the result does not depend
on these distances: :func:`proposed`.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np
from scipy.optimize import brentq

from woodpecker.base.arrays import Bools, Floats, Ints

# The reason that a map gives where ever thinner pieces accumulate at a point.
ACCUMULATE = "borders accumulate"
TIE = 2.0**-36  # a margin is zero if it is smaller than this part of its terms: a border
# point is known to some 2**-44 times the condition number of the equations that it solves
STEEP_TIE = 2.0**-46  # the same for terms above 1, which come from steep slopes: where an
# event time has a root singularity all later margins have infinite slopes, and few are zero

# A *root* below is a root singularity at the border of a piece, a + b h^s + c h at a distance h: an
# event time has it, with s = 1/2, at a grazing. There slopes are unbounded.
# A larger slope is that of a root right at its border: infinite, but for rounding.
INFINITE_SLOPE = 1e10
LARGE_SLOPE = 1e3  # above it, rounding of a border point changes the image noticeably
# Scaled: here steep slopes keep some correct digits, and curvature is negligible.
LIMIT_DISTANCE = 2.0**-33
FIT_DISTANCES = tuple(
    LIMIT_DISTANCE * 4.0**-k for k in range(-2, 5)
)  # distances of the images by which roots are fitted, three in turn
SMOOTH = 2.0**-18  # relative: over such distances slopes of a smooth piece change by less
DISTANCES = tuple(2.0**-n for n in (22, 28, 34, 40, 46, 16, 10))  # scaled, of proposals
NEAREST = min(DISTANCES)
# Scaled: distances at which accumulating pieces are sampled, and how many of them must show one:
# at the smallest distance rounding may decide.
ACCUMULATION_DISTANCES, LEAST_SEEN = tuple(2.0**-n for n in (33, 36, 39, 42, 46, 50)), 5
# Times the tolerance of ties: how far outside an accumulating piece is evaluated.
ACCUMULATING_TIE = 2.0**8
# Times the change that slopes predict: values farther off have other event times.
SAME_SOLUTION = 4.0
# Largest rounding error of a fitted exponent and, relatively, of a distance; also the largest part
# of the change of a value that a fitted root may leave unexplained.
FIT_TOLERANCE = 2.0**-10
LEAST_POWER = 2.0**-4  # least exponent of a root: slower growth is a logarithm, without limit
SQUARE = 2.0**-12  # exponents closer than this to 1/2 are square roots

Lengths = Sequence[float] | float
"""The d + k lengths of coordinates and parameters that count as 1, or a common one."""


class SpaceImage(NamedTuple):
    """The image of a point under a piece."""

    value: Floats  # (d,) P(x, p)
    jacobian: Floats  # (d, d + k) derivatives in x and p
    margins: Floats  # (m,) h_j(x, p), positive where the map takes this piece
    gradients: Floats  # (m, d + k) derivatives of the margins
    codes: Ints  # (m,) of the margins, ascending; they may differ from point to point of a piece
    piece: SpacePiece  # the piece, which can be continued from this point
    reason: str = ""  # why there is no value; empty if there is one
    lengths: Lengths = 1.0  # of x and p that count as 1; over two parameters those of the plane

    def sizes(self, x: Floats, p: Floats) -> Floats:
        """The sizes (d + k,) of coordinates and parameters, of which rounding changes a part."""
        # a coordinate near 0 has the size of its length, but no wide window makes it less exact
        sizes: Floats = np.maximum(np.abs(np.concatenate([x, p])), np.minimum(1.0, self.lengths))
        return sizes

    def tied(self, x: Floats, p: Floats, times: float = 1.0) -> Bools:
        """Which margins (m,) vanish at the point (x, p), to ``times`` the rounding error."""
        size = np.abs(self.gradients) @ self.sizes(x, p)
        found: Bools = np.abs(self.margins) <= times * np.maximum(
            TIE * np.minimum(size, 1.0), STEEP_TIE * size
        )
        return found

    def begins_along(self, x: Floats, p: Floats, direction: Floats) -> bool:
        """Whether the map takes this piece infinitesimally beside (x, p) in a direction."""
        zero = self.tied(x, p)
        signs = np.where(zero, self.gradients @ direction, self.margins)
        return bool((signs > 0.0).all())

    @property
    def is_whole(self) -> bool:
        """Whether there is a value, with finite slopes."""
        return not self.reason and bool((np.abs(self.jacobian) < INFINITE_SLOPE).all())

    @property
    def has_small_slopes(self) -> bool:
        """Whether there is a value, and no slope is as steep as beside a root singularity."""
        return not self.reason and bool(np.abs(self.jacobian).max() <= LARGE_SLOPE)

    def index_of(self, code: int) -> int:
        """The index of the margin with a code; -1 if there is none here."""
        codes = self.codes.tolist()  # so short that a search in a list is faster
        return codes.index(code) if code in codes else -1


class Named(Protocol):
    """What a piece is called."""

    @property
    def key(self) -> Hashable:
        """An identifier: two pieces are the same if and only if their keys are equal."""

    @property
    def word(self) -> str:
        """The readable name, such as a sequence of events."""

    def cause(self, code: int) -> str:
        """A sentence on what happens where the margin with a code vanishes."""


class SpacePiece(Named, Protocol):
    """A smooth map with margins. It may remember its last event times, to start from them."""

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """The image of a point, also where the map takes another piece."""


def slopes_of(piece: SpacePiece, x: Floats, p: Floats) -> Floats:
    """(d, d) derivatives of a piece in x, by its own method ``slopes`` if any; nan if no value."""
    if (own := getattr(piece, "slopes", None)) is not None:
        found: Floats = own(x, p)
        return found
    image = piece.at(x, p)
    return np.full((len(x), len(x)), np.nan) if image.reason else image.jacobian[:, : len(x)]


def on_section(image: SpaceImage, code: int) -> bool:
    """Whether a margin vanishes as an event falls on a section, by a method of the piece if any."""
    told = getattr(first_piece_of(image), "on_section", None)
    return told is not None and bool(told(code))


class SpaceMap(Protocol):
    """A map of R^d that consists of smooth pieces."""

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """The image of a point under the piece that the map takes there."""

    def beside(self, x: Floats, p: Floats, direction: Floats) -> SpaceImage:
        """The image under the piece that the map takes infinitesimally beside a point.

        The direction is (d + k,). A margin that vanishes at the point counts as positive if its
        derivative along the direction is; no point at a distance decides.
        """


def taken(map_: SpaceMap, x: Floats, p: Floats) -> tuple[Hashable, Floats]:
    """The key of the piece at a point, and its value (d,), by the map's own method if any."""
    own = getattr(map_, "taken", None)
    if own is None:
        image = map_.at(x, p)
        return image.piece.key, image.value
    found: tuple[Hashable, Floats] = own(x, p)
    return found


def image_at(map_: SpaceMap, x: Floats, p: Floats) -> SpaceImage:
    """The image of a point under the map, or the reason why there is none.

    The reason is that borders accumulate if the map has a value and only its piece has none.
    """
    image = map_.at(x, p)
    if image.reason and not np.isnan(taken(map_, x, p)[1]).any():
        return image._replace(reason=ACCUMULATE)
    return image


def margins_decide(map_: SpaceMap) -> bool:
    """Whether a map guarantees that it takes a piece exactly where all margins are positive."""
    return getattr(map_, "margins_decide", False)


def proposed(
    map_: SpaceMap, x: Floats, p: Floats, direction: Floats, scale: Sequence[float]
) -> SpaceImage:
    """The image of a point (d,) under the piece infinitesimally beside it, or why there is none.

    There is none where the map has no value beside the point, or where its pieces accumulate.
    ``scale`` holds the lengths that count as 1, of the d coordinates and the k parameters.
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
        around = around or image  # none of its borders passes here: a thinner piece may lie between
    return around or map_.at(x, p)._replace(reason=lost or ACCUMULATE)


@dataclass(frozen=True, slots=True)
class PieceView:
    """A piece as one of another space, with its own key, word and sentences; abstract."""

    own: Named

    @property
    def key(self) -> Hashable:
        """The key of the piece."""
        return self.own.key

    @property
    def word(self) -> str:
        """The word of the piece."""
        return self.own.word

    def cause(self, code: int) -> str:
        """A sentence on what happens where the margin with a code vanishes."""
        return self.own.cause(code)


@dataclass(frozen=True, slots=True)
class Accumulating(PieceView):
    """One of the ever thinner pieces that accumulate at a border; it stands for their limit there.

    Of its margins that vanish beside that border only one is kept, set to zero all along it.
    """

    own: SpacePiece
    code: int  # of the margin that is kept
    dropped: frozenset[int]  # codes of the other margins that vanish

    def at(self, x: Floats, p: Floats) -> SpaceImage:
        """The image of a point on the border; none if the piece lies too far from this point."""
        image = self.own.at(x, p)
        if image.reason:
            return image
        codes = image.codes.tolist()
        kept = np.array([code not in self.dropped for code in codes])
        bounds = np.array([code == self.code for code in codes])
        if not ((kept & ~bounds) | image.tied(x, p, ACCUMULATING_TIE)).all():
            return image._replace(reason=ACCUMULATE)
        return image._replace(
            margins=np.where(bounds, 0.0, image.margins)[kept], gradients=image.gradients[kept],
            codes=image.codes[kept], piece=replace(self, own=image.piece),
        )  # fmt: skip


def accumulated(
    map_: SpaceMap, x: Floats, p: Floats, direction: Floats, lengths: Floats
) -> SpaceImage | None:
    """The limit at (x, p) of pieces that accumulate there in a direction; None if none do.

    Where chattering impacts accumulate, words differ from piece to piece but images converge.
    """
    unit, d, found = direction / np.abs(direction / lengths).max(), len(x), list[SpaceImage]()
    for distance in ACCUMULATION_DISTANCES:
        near = map_.at(x + distance * unit[:d], p + distance * unit[d:])
        image = near if near.reason else near.piece.at(x, p)
        if image.reason or not all(_tends_to(each, image, unit) for each in found):
            break
        found.append(image)
    if len(found) < LEAST_SEEN or found[0].piece.key == found[-1].piece.key:
        return None
    last = found[-1]
    bounds = last.tied(x, p, ACCUMULATING_TIE) | (last.margins <= 0.0)
    inward = bounds & (last.gradients @ unit > 0.0)
    if not inward.any():
        return None
    code = int(last.codes[np.where(inward, np.abs(last.margins), math.inf).argmin()])
    dropped = frozenset(last.codes[bounds].tolist()) - {code}
    image = Accumulating(last.piece, code, dropped).at(x, p)
    return None if image.reason else image


def _tends_to(image: SpaceImage, last: SpaceImage, unit: Floats) -> bool:
    """Whether the images of two accumulating pieces are as close as their distances require."""
    change = np.abs(image.jacobian @ unit) + np.abs(last.jacobian @ unit) + np.abs(last.value)
    near = np.abs(last.value - image.value) <= SAME_SOLUTION * ACCUMULATION_DISTANCES[0] * change
    return bool(near.all())


def limit(near: SpaceImage, x: Floats, p: Floats, unit: Floats) -> SpaceImage:
    """The one-sided limit at (x, p) of the piece of a nearby image."""
    # Where the piece has no value at the point, or its derivatives there are rounding errors, take
    # those beside it. At a root singularity they grow without bound: `root_of` finds the limit.
    there = _at_border(near.piece, x, p, unit)
    finite = not there.reason and np.isfinite(there.gradients).all()
    if finite and _alike(there.jacobian, near.jacobian, SMOOTH):
        return there
    away, d = LIMIT_DISTANCE * unit, len(x)
    closer = near.piece.at(x + away[:d], p + away[d:])
    if closer.reason:
        return closer
    if not there.reason and _converge(near.jacobian, closer.jacobian, there.jacobian):
        return _with_settled_gradients(there, near, closer)
    along = closer.jacobian @ away
    value = closer.value - along
    root = root_of(near.piece, x, p, unit)
    if root is not None:
        value = root.value
    elif (
        not there.reason
        and np.abs(there.value - value).max() <= SAME_SOLUTION * np.abs(along).max()
    ):
        value = there.value  # else that of the other event time: two merge at the border
    return closer._replace(value=value, margins=closer.margins - closer.gradients @ away)


def _at_border(piece: SpacePiece, x: Floats, p: Floats, unit: Floats) -> SpaceImage:
    """The image of a border point from which a direction leads into the piece."""
    # Rounding may put it where the piece has no value: there it is mirrored at the border.
    image, d = piece.at(x, p), len(x)
    rates = image.gradients @ unit
    beyond = (image.margins < 0.0) & (rates > 0.0) & image.tied(x, p)
    if not (image.reason and beyond.any()):
        return image
    way = 2.0 * float((-image.margins[beyond] / rates[beyond]).max()) * unit
    return piece.at(x + way[:d], p + way[d:])


class RootSingularity(NamedTuple):
    """A root singularity at the border of a piece: a + b h^s + c h at a distance h from it."""

    value: Floats  # (d,) a
    exponent: float  # s
    growth: Floats  # (d,) change of the slopes towards the border, with the signs of b


def root_of(piece: SpacePiece, x: Floats, p: Floats, unit: Floats) -> RootSingularity | None:
    """The root singularity at which a piece ends at (x, p), along a direction; None without one."""
    # Closer to the border higher terms matter less, until slopes are all rounding.
    best, least, d = None, FIT_TOLERANCE, len(x)
    images, away = list[SpaceImage](), list[float]()
    for distance in FIT_DISTANCES:
        image = piece.at(x + distance * unit[:d], p + distance * unit[d:])
        if image.reason:
            break
        images, away = [image, *images[:2]], [distance, *away[:2]]
        if len(images) < 3:
            continue
        found, off = _fitted(images, unit, away)
        if found is None:
            break
        if off < least:
            best, least = found, off
        if off <= SMOOTH:
            break  # good enough
    return best


def _fitted(
    images: Sequence[SpaceImage], unit: Floats, away: list[float]
) -> tuple[RootSingularity | None, float]:
    """The root singularity at the end of a piece, fitted to images at distances, and its error."""
    # Slopes at three distances, each about four times the one before, give the exponent s with
    # 0 < s < 1, from the steepest component; values at two of them give the limit a. The error is
    # that of the value at the third, relative to its difference from the first.
    h = _distances(images, unit, away)
    slopes = np.array([image.jacobian @ unit for image in images])
    every = slopes[:-1] - slopes[1:]  # without c: of s b h^(s - 1) only
    most = int(np.abs(every[0]).argmax())  # the steepest component: all have the same exponent
    bends: list[float] = every[:, most].tolist()
    if not (bends[0] * bends[1] > 0.0 and abs(bends[0]) > SMOOTH * abs(slopes[0, most])):
        return None, math.inf
    about = 1.0 - math.log(bends[0] / bends[1]) / math.log(4.0)

    def unequal(s: float) -> float:
        powers = [math.pow(each / h[1], s - 1.0) for each in h]
        return (powers[0] - powers[1]) * bends[1] - (powers[1] - powers[2]) * bends[0]

    low, high = about - FIT_TOLERANCE, about + FIT_TOLERANCE
    if not LEAST_POWER < low < high < 1.0 or not unequal(low) * unequal(high) < 0.0:
        return None, math.inf
    s = float(brentq(unequal, low, high))
    s = 0.5 if abs(s - 0.5) <= SQUARE else s
    # With B = b h^s and C = c h at the nearest point: values a + B + C and a + t^s B + t C at h and
    # t h, slope times distance s B + C (`steep`). Eliminating B and C gives a.
    t, steep = h[1] / h[0], slopes[0] * h[0]
    part = (t**s - t * s) / (1.0 - s)
    near, far, farthest = (image.value for image in images)
    value = (far - part * near - (t - part) * steep) / (1.0 - part)
    t, b = h[2] / h[0], (near - value - steep) / (1.0 - s)
    rest = float(np.abs(farthest - (value + t**s * b + t * (steep - s * b))).max())
    way = float(np.abs(farthest - near).max())  # zero if all of it is rounding
    return RootSingularity(value, s, every[0]), rest / way if way > 0.0 else math.inf


def _distances(images: Sequence[SpaceImage], unit: Floats, away: list[float]) -> list[float]:
    """Distances of images of a piece from the border, measured by the margin that vanishes."""
    # So close to the border the coordinates are rounded; the margin has the same rounded ones.
    rates = images[0].gradients @ unit
    (ahead,) = np.nonzero((rates > 0.0) & (images[0].margins > 0.0))
    if not len(ahead):
        return away
    code = int(images[0].codes[ahead[(images[0].margins[ahead] / rates[ahead]).argmin()]])
    found = list[float]()
    for image in images:
        k = image.index_of(code)
        rate = float(image.gradients[k] @ unit) if k >= 0 else 0.0
        found.append(float(image.margins[k]) / rate if rate else math.nan)
    near = all(abs(a - b) <= FIT_TOLERANCE * b for a, b in zip(found, away, strict=True))
    return found if near else away


def _converge(one: Floats, closer: Floats, there: Floats) -> bool:
    """Whether derivatives beside a point converge to those at the point."""
    return bool(np.abs(closer - there).max() <= 0.5 * np.abs(one - there).max())


def _with_settled_gradients(there: SpaceImage, one: SpaceImage, closer: SpaceImage) -> SpaceImage:
    """The image at a point, with those gradients from beside it that do not converge to its own."""
    # Margins that vanish at the point need not be the same ones as beside it.
    every = (there, one, closer)
    shared = np.array(sorted(set.intersection(*(set(each.codes.tolist()) for each in every))), int)
    rows = [np.searchsorted(each.codes, shared) for each in every]
    own, first, last = (each.gradients[k] for each, k in zip(every, rows, strict=True))
    far, near = (np.abs(each - own).max(axis=1, initial=0.0) for each in (first, last))
    settled = near <= np.maximum(0.5 * far, SMOOTH * np.abs(last).max(axis=1, initial=0.0))
    gradients = there.gradients.copy()
    gradients[rows[0]] = np.where(settled[:, None], own, last)
    return there._replace(gradients=gradients)


def _alike(one: Floats, other: Floats, within: float) -> bool:
    size = max(1.0, float(np.abs(one).max()), float(np.abs(other).max()))
    return bool(np.abs(one - other).max() <= within * size)


@dataclass(frozen=True, slots=True)
class Chain:
    """A composition of pieces; the margins of all of them become functions of the first point."""

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
        """The last image, with the margins of all pieces, and derivatives in the first point."""
        images, value = [], x
        for piece in self.pieces:
            images.append(piece.at(value, p))
            if images[-1].reason:
                return images[-1]
            value = images[-1].value
        return chained(images)

    def cause(self, code: int) -> str:
        """The sentence of the piece to which the margin belongs."""
        rest, i = divmod(code, len(self.pieces))
        return self.pieces[i].cause(rest)


def chained(images: Sequence[SpaceImage]) -> SpaceImage:
    """Compose consecutive images: the last value, with derivatives in the first point."""
    if len(images) == 1:
        return images[0]
    (d, columns), n = images[0].jacobian.shape, len(images)
    inner = np.eye(d, columns)  # derivatives of the point that is reached, in (x, p)
    margins, gradients, codes = [], [], []
    for i, image in enumerate(images):
        margins.append(image.margins)
        gradients.append(_through(image.gradients, inner, d))
        codes.append(n * image.codes + i)  # so that divmod(code, n) gives both back
        inner = _through(image.jacobian, inner, d)
    order = np.argsort(np.concatenate(codes), kind="stable")
    return SpaceImage(
        images[-1].value, inner, np.concatenate(margins)[order], np.concatenate(gradients)[order],
        np.concatenate(codes)[order], Chain(tuple(image.piece for image in images)),
        lengths=images[0].lengths,
    )  # fmt: skip


def length_of(image: SpaceImage) -> int:
    """The number of pieces in an image."""
    return len(image.piece.pieces) if isinstance(image.piece, Chain) else 1


def first_piece_of(image: SpaceImage) -> SpacePiece:
    """The piece of an image (the first of a chain); with all margins if pieces accumulate."""
    piece = image.piece.pieces[0] if isinstance(image.piece, Chain) else image.piece
    return piece.own if isinstance(piece, Accumulating) else piece


def images_of_chain(image: SpaceImage, x: Floats, p: Floats) -> list[SpaceImage]:
    """The images that make up a chain, in turn; the image itself if it is of a single piece."""
    if not isinstance(image.piece, Chain):
        return [image]
    found = list[SpaceImage]()
    for piece in image.piece.pieces:
        found.append(piece.at(found[-1].value if found else x, p))
    return found


def _through(outer: Floats, inner: Floats, d: int) -> Floats:
    """The chain rule: derivatives (m, d + k) in an image become those in its preimage and p."""
    found: Floats = outer[:, :d] @ inner
    found[:, d:] += outer[:, d:]
    return found
