"""Orbits x_0 .. x_(n-1) in R^d at parameters p in R^k, P_i(x_i, p) = x_(i+1), and their conditions.

A *condition* closes an orbit. A cycle returns to x_0. A *jump crossing* ends at a border point, at
which the set-valued map takes the whole segment between the two one-sided limits P and P':
x_0 = (1 - s) P(x_(n-1)) + s P'(x_(n-1)), 0 < s < 1. At s = 0 and s = 1 it is a cycle at the border.
"""

from __future__ import annotations

import math
from collections.abc import Container, Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Protocol

import numpy as np

from woodpecker.base.arrays import STEP, Complexes, Floats
from woodpecker.engine.maps import (
    Chain,
    SpaceImage,
    SpacePiece,
    chained,
    first_piece_of,
    length_of,
    limit,
    root_of,
    slopes_of,
)

BEYOND_END = 2.0**-36  # scaled: by rounding a special point may lie so far beyond a span
INSIDE = 2.0**-22  # times the size of a border point: how far inside a piece its limit is taken
# Part of the largest scaled rate of a margin. Along curves over two parameters one that changes
# less with x hardly depends on it, and limits are taken along the parameters, too.
DEPENDS = 0.1
CLEAR = 2.0**-10  # part of the distance from a border that a difference spans at most
LARGEST_MARGIN = 16.0  # times the prescribed margin: a larger one belongs to another event time
LEVEL, LEVELS = 2.0**-26, 3  # relative error of a prescribed margin, and most steps to reach it
SHORTEST = 2.0**-40  # of a step of differences: orbits are rounded to some 2**-50


@dataclass(frozen=True, slots=True, eq=False)
class SpaceOrbit:
    """Points of a map, each with its image under a piece."""

    x: Floats  # (n, d) points
    p: Floats  # (k,) parameters
    share: float  # s, the weight of the outer limit in a jump crossing; 0 for a cycle
    images: tuple[SpaceImage, ...]  # n images, one of each point
    outer: SpaceImage | None = None  # image of the last point on the far side of the border
    unknowns: Floats = field(init=False)  # (n d + k + 1,) all points, the parameters, the share

    def __post_init__(self) -> None:
        unknowns = np.concatenate((self.x.ravel(), self.p, (self.share,)))
        object.__setattr__(self, "unknowns", unknowns)

    @property
    def all_images(self) -> tuple[SpaceImage, ...]:
        """All images, the outer one last."""
        return self.images if self.outer is None else (*self.images, self.outer)

    @property
    def is_defined(self) -> bool:
        """Whether every piece has a value."""
        return not any(image.reason for image in self.all_images)

    @property
    def word(self) -> str:
        """The words of its pieces; a slash separates the two sides of the border of a crossing."""
        inner = " | ".join(image.piece.word for image in self.images)
        return inner if self.outer is None else f"{inner} / {self.outer.piece.word}"

    @property
    def keys(self) -> tuple[Hashable, ...]:
        """The keys of its pieces; the last one of a crossing is the set of its two sides."""
        keys = tuple(image.piece.key for image in self.images)
        if self.outer is None:
            return keys
        return *keys[:-1], frozenset((keys[-1], self.outer.piece.key))

    @property
    def end(self) -> Floats:
        """The last image."""
        return self.images[-1].value

    def with_image(self, i: int, image: SpaceImage) -> SpaceOrbit:
        """The same points, with another image of the i-th."""
        return replace(self, images=(*self.images[:i], image, *self.images[i + 1 :]))

    def point_of(self, i: int) -> int:
        """The index of the point to which the i-th of :attr:`taken` belongs."""
        return min(i, len(self.x) - 1)

    def margin(self, i: int, code: int) -> float:
        """The margin with a code of the i-th of :attr:`taken`; nan if that has no such margin."""
        image = self.all_images[i]
        k = image.index_of(code)
        return float(image.margins[k]) if k >= 0 else math.nan

    def gradient(self, i: int, code: int) -> Floats:
        """Derivatives (n d + k + 1,) of that margin in all unknowns; nan without it."""
        image = self.all_images[i]
        k = image.index_of(code)
        if k < 0:
            return np.full(len(self.unknowns), np.nan)
        return self.columns(self.point_of(i), image.gradients[k])

    def columns(self, i: int, rows: Floats) -> Floats:
        """Extend derivatives (..., d + k) in the i-th point and p to columns of all unknowns."""
        (n, d), k = self.x.shape, len(self.p)
        wide = np.zeros((*rows.shape[:-1], n * d + k + 1))
        wide[..., i * d : (i + 1) * d] = rows[..., :d]
        wide[..., n * d : n * d + k] = rows[..., d:]
        return wide

    @property
    def monodromy(self) -> Floats:
        """(d, d) derivative of the last image in x_0: the product of the Jacobians."""
        d = self.x.shape[1]
        product = self.images[0].jacobian[:, :d]
        for image in self.images[1:]:
            product = image.jacobian[:, :d] @ product
        return product

    def multipliers(self) -> Complexes:
        """(d,) eigenvalues of the monodromy, the largest first; nan if a slope is not finite."""
        monodromy = self.monodromy
        if not np.isfinite(monodromy).all():  # as beyond a root singularity
            return np.full(len(monodromy), np.nan, dtype=complex)
        found: Complexes = np.linalg.eigvals(monodromy).astype(complex)
        return found[np.argsort(-np.abs(found), kind="stable")]

    def rotated(self, first: int) -> SpaceOrbit:
        """The same cycle, numbered from another of its points."""
        images = (*self.images[first:], *self.images[:first])
        return replace(self, x=np.roll(self.x, -first, axis=0), images=images)


def orbit_of(
    pieces: Sequence[SpacePiece],
    x: Floats,
    p: Floats,
    share: float = 0.0,
    outer: SpacePiece | None = None,
) -> SpaceOrbit:
    """The orbit of given points (n, d) under given pieces."""
    x, p = np.asarray(x, dtype=float), np.asarray(p, dtype=float)
    images = tuple(piece.at(point, p) for piece, point in zip(pieces, x, strict=True))
    return SpaceOrbit(x, p, share, images, None if outer is None else outer.at(x[-1], p))


class Condition(Protocol):
    """Equations that an orbit has to satisfy."""

    def residual(self, orbit: SpaceOrbit) -> Floats:
        """(m,) residuals, zero if the orbit satisfies them."""

    def rows(self, orbit: SpaceOrbit) -> Floats:
        """(m, n d + k + 1) derivatives of the residuals in all unknowns of the orbit."""


@dataclass(frozen=True, slots=True)
class Closed:
    """P_i(x_i) = x_(i+1), and the last image, or the mixture of both limits, is x_0."""

    def residual(self, orbit: SpaceOrbit) -> Floats:
        """(n d,) images minus the points that they should be."""
        if len(orbit.images) == 1 and orbit.outer is None:  # most curves: fixed points
            return np.asarray(orbit.images[0].value - orbit.x[0])
        values = np.array([image.value for image in orbit.images])
        if orbit.outer is not None:
            values[-1] += orbit.share * (orbit.outer.value - values[-1])
        values[:-1] -= orbit.x[1:]
        values[-1] -= orbit.x[0]
        return values.ravel()

    def rows(self, orbit: SpaceOrbit) -> Floats:
        """Their derivatives."""
        (n, d), k = orbit.x.shape, len(orbit.p)
        rows: Floats = _minus_next_point(n, d, k).copy()
        if n == 1 and orbit.outer is None:
            rows[:, : d + k] += orbit.images[0].jacobian
            return rows
        for i, image in enumerate(orbit.images):
            jacobian = image.jacobian
            if orbit.outer is not None and i == n - 1:
                jacobian = (1.0 - orbit.share) * jacobian + orbit.share * orbit.outer.jacobian
                rows[-d:, -1] = orbit.outer.value - image.value
            block = slice(i * d, i * d + d)
            rows[block, block] += jacobian[:, :d]
            rows[block, n * d : n * d + k] = jacobian[:, d:]
        return rows


@lru_cache
def _minus_next_point(n: int, d: int, k: int) -> Floats:
    """Derivatives (n d, n d + k + 1) of -x_(i+1), cyclically, for n points."""
    rows = np.zeros((n * d, n * d + k + 1))
    rows[:, : n * d] = -np.roll(np.eye(n * d), d, axis=1)
    return rows


@dataclass(frozen=True, slots=True)
class Chained:
    """P_i(x_i) = x_(i+1) for all points but the last: an orbit that need not close."""

    def residual(self, orbit: SpaceOrbit) -> Floats:
        """((n - 1) d,) images minus the next points."""
        return Closed().residual(orbit)[: -orbit.x.shape[1]]

    def rows(self, orbit: SpaceOrbit) -> Floats:
        """Their derivatives."""
        return Closed().rows(orbit)[: -orbit.x.shape[1]]


@dataclass(frozen=True, slots=True)
class OnBorder:
    """A margin vanishes, or has a prescribed value."""

    image: int  # index in `SpaceOrbit.all_images`: 0 .. n - 1, or n for the outer image
    code: int  # code of the margin
    value: float = 0.0  # of the margin; small and positive for an orbit right beside the border

    def residual(self, orbit: SpaceOrbit) -> Floats:
        """(1,) the margin minus its value; nan if the piece has no such margin here."""
        return np.array([orbit.margin(self.image, self.code) - self.value])

    def rows(self, orbit: SpaceOrbit) -> Floats:
        """(1, ...) derivatives of the margin."""
        return orbit.gradient(self.image, self.code)[None]

    def is_near(self, orbit: SpaceOrbit) -> bool:
        """Whether a prescribed small margin is still small: a larger one is of another path.

        Beyond a grazing the event is missing, and the path takes the next one of its kind instead.
        """
        margin = orbit.margin(self.image, self.code)
        return not self.value or 0.0 < margin < LARGEST_MARGIN * self.value

    def moved_to_margin(self, orbit: SpaceOrbit) -> SpaceOrbit:
        """Move the point of a cycle across its border until the margin has its prescribed value."""
        # along such a level a root singularity is constant, so that the other equations are smooth
        i, d = self.image, orbit.x.shape[1]
        for _ in range(LEVELS) if self.value else ():
            image, x = orbit.images[i], orbit.x.copy()
            k = image.index_of(self.code)
            off = self.value - float(image.margins[k])
            if abs(off) <= LEVEL * self.value:
                break
            inward = image.gradients[k, :d]
            x[i] += off * inward / (inward @ inward)
            orbit = replace(orbit, x=x).with_image(i, image.piece.at(x[i], orbit.p))
            if not orbit.is_defined or not self.is_near(orbit):
                break
        return orbit

    def is_met(self, orbit: SpaceOrbit) -> bool:
        """Whether the margin vanishes up to rounding, as :meth:`SpaceImage.tied` decides."""
        image, x = orbit.all_images[self.image], orbit.x[orbit.point_of(self.image)]
        k = image.index_of(self.code)
        return k >= 0 and bool(image.tied(x, orbit.p)[k])


@dataclass(frozen=True, slots=True)
class AtLimit:
    """x_0 of a jump crossing in R^1 is one of the two limits: s is 0 or 1."""

    outer: bool  # whether it is the outer limit, s = 1

    def residual(self, orbit: SpaceOrbit) -> Floats:
        """(1,) the limit minus x_0."""
        return np.asarray(orbit.all_images[-1 if self.outer else -2].value - orbit.x[0])

    def rows(self, orbit: SpaceOrbit) -> Floats:
        """(1, ...) its derivatives."""
        image = orbit.all_images[-1 if self.outer else -2]
        row = orbit.columns(len(orbit.x) - 1, image.jacobian)
        row[0, 0] -= 1.0
        return row


@dataclass(frozen=True, slots=True)
class Held:
    """An unknown has a prescribed value."""

    column: int  # index in :attr:`SpaceOrbit.unknowns`
    value: float

    def residual(self, orbit: SpaceOrbit) -> Floats:
        """(1,) the unknown minus its value."""
        return np.array([orbit.unknowns[self.column] - self.value])

    def rows(self, orbit: SpaceOrbit) -> Floats:
        """(1, ...) a unit vector."""
        row = np.zeros((1, len(orbit.unknowns)))
        row[0, self.column] = 1.0
        return row


@dataclass(frozen=True, slots=True)
class Multiplier:
    """A cycle has a multiplier 1 (LP) or -1 (PD), or two multipliers with the product 1 (NS)."""

    kind: str  # "LP", "PD" or "NS"
    # (d + k) units of difference steps for a point and the parameters; by default max(1, |value|)
    scale: tuple[float, ...] = ()

    def value(self, orbit: SpaceOrbit) -> float:
        """det(M - 1), det(M + 1), or the product of mu_i mu_j - 1 over all pairs i < j."""
        monodromy = orbit.monodromy
        d, sign = len(monodromy), -1.0 if self.kind == "LP" else 1.0
        if d == 1 and self.kind != "NS":
            return float(monodromy[0, 0]) + sign
        if not np.isfinite(monodromy).all():  # a point moved beyond a root has no slopes
            return math.nan
        if self.kind == "NS":
            return float(np.linalg.det(_pairs(monodromy) - np.eye(d * (d - 1) // 2)))
        return float(np.linalg.det(monodromy + sign * np.eye(d)))

    def residual(self, orbit: SpaceOrbit) -> Floats:
        """(1,) the value of the test function."""
        return np.array([self.value(orbit)])

    def rows(self, orbit: SpaceOrbit) -> Floats:
        """(1, ...) its derivatives, by central differences of the smooth pieces."""
        row = np.zeros((1, len(orbit.unknowns)))
        for i in range(len(orbit.x)):
            row += orbit.columns(i, self._gradient(orbit, i))
        return row

    def _gradient(self, orbit: SpaceOrbit, i: int) -> Floats:
        """(d + k,) derivatives of the value through the i-th piece, in its point and p."""
        # Differences are taken across the nearest border and along it: beside a root singularity
        # slopes change fast across the border, but along it only with the curvature of the border.
        image, at = orbit.images[i], np.concatenate((orbit.x[i], orbit.p))
        scale = np.array(self.scale) if self.scale else np.maximum(1.0, np.abs(at))
        rows = image.gradients * scale
        size = np.linalg.norm(rows, axis=1)
        known = np.isfinite(size) & (size > 0.0)
        margins, rows, size = np.abs(image.margins[known]), rows[known], size[known]
        ways, most = np.eye(len(at)), STEP
        if len(size):
            nearest = int((margins / size).argmin())
            ways = np.linalg.qr(np.column_stack((rows[nearest], ways)))[0].T
            most = min(most, math.sqrt(CLEAR * margins[nearest] / size[nearest]))
        found = np.zeros(len(at))
        for way in ways:
            rates = np.abs(rows @ way)
            away = (margins[rates > 0.0] / rates[rates > 0.0]).min(initial=math.inf)
            h = max(min(most, CLEAR * away), SHORTEST)
            found += self._difference(orbit, i, h * way * scale) / h * way / scale
        return found

    def _difference(self, orbit: SpaceOrbit, i: int, step: Floats) -> float:
        """Central difference of the value along a step (d + k,); one-sided where the piece ends."""
        image, at = orbit.images[i], np.concatenate((orbit.x[i], orbit.p))
        d = orbit.x.shape[1]

        def value(part: float) -> float:
            to = at + part * step
            slopes = np.column_stack(
                (slopes_of(image.piece, to[:d], to[d:]), image.jacobian[:, d:])
            )
            return self.value(orbit.with_image(i, image._replace(jacobian=slopes)))

        ahead, behind = value(1.0), value(-1.0)
        if not math.isnan(ahead + behind):
            return 0.5 * (ahead - behind)
        side = -1.0 if math.isnan(ahead) else 1.0
        return 0.5 * side * (4.0 * value(side) - 3.0 * self.value(orbit) - value(2.0 * side))


def _pairs(matrix: Floats) -> Floats:
    """The second compound matrix: its eigenvalues are the products of pairs of eigenvalues."""
    d = len(matrix)
    first, second = np.triu_indices(d, 1)
    a = matrix[np.ix_(first, first)] * matrix[np.ix_(second, second)]
    b = matrix[np.ix_(first, second)] * matrix[np.ix_(second, first)]
    return np.asarray(a - b)


def pulled_inside(guess: SpaceOrbit, last: SpaceOrbit) -> SpaceOrbit:
    """Move those points of a guess that have no image, until their margins are as in ``last``."""
    # A branch may run along the end of a piece (a square root): the tangent then leads beyond it.
    x, images, d = guess.x.copy(), list(guess.images), guess.x.shape[1]
    for i, before in enumerate(last.images[: len(images)]):
        for k in np.flatnonzero(images[i].margins < 0.0) if images[i].reason else ():
            m = before.index_of(int(images[i].codes[k]))
            inward = images[i].gradients[k, :d]
            if m >= 0 and inward.any():
                x[i] += (before.margins[m] - images[i].margins[k]) * inward / (inward @ inward)
                images[i] = images[i].piece.at(x[i], guess.p)
                break
    return replace(guess, x=x, images=tuple(images))


def held_at(orbit: SpaceOrbit, column: int, value: float) -> SpaceOrbit:
    """The orbit with an unknown set exactly to a value that it has up to rounding."""
    (n, d), k = orbit.x.shape, len(orbit.p)
    at = orbit.unknowns.copy()
    at[column] = value
    return replace(orbit, x=at[: n * d].reshape(n, d), p=at[n * d : n * d + k], share=float(at[-1]))


def at_ends(
    orbit: SpaceOrbit, free: Sequence[int], spans: Sequence[tuple[float, float]],
    p_scale: Sequence[float],
) -> SpaceOrbit:  # fmt: skip
    """The orbit, with free parameters that lie beyond their spans by rounding set to the ends."""
    for k, (low, high) in zip(free, spans, strict=True):
        value = float(orbit.p[k])
        end = min(max(value, low), high)
        if 0.0 < abs(value - end) <= BEYOND_END * p_scale[k]:
            orbit = held_at(orbit, orbit.x.size + k, end)
    return orbit


def with_unknowns(
    orbit: SpaceOrbit, unknowns: Floats, held: Container[int] = (), *, along: bool = False
) -> SpaceOrbit:
    """The orbit of the same pieces with other unknowns; points in ``held`` are on borders."""
    # along a curve of border points derivatives are needed that are no rounding errors
    (n, d), k = orbit.x.shape, len(orbit.p)
    x, p, share = unknowns[: n * d].reshape(n, d), unknowns[n * d : n * d + k], float(unknowns[-1])
    images = [image.piece.at(point, p) for image, point in zip(orbit.images, x, strict=True)]
    for i, image in enumerate(images):
        if i in held and (along or not image.is_whole):
            at = orbit.x[i], orbit.p, x[i], p
            images[i] = _inside(orbit.images[i], image, *at, may_be_smooth=True)
    if orbit.outer is None:
        return SpaceOrbit(x, p, share, tuple(images))
    images[-1] = _at_border(orbit.images[-1], images[-1], orbit, x[-1], p)
    outer = _at_border(orbit.outer, orbit.outer.piece.at(x[-1], p), orbit, x[-1], p)
    if d == 1:
        share = _share(float(x[0, 0]), images[-1], outer, share)
    return SpaceOrbit(x, p, share, tuple(images), outer)


def placed_at(orbit: SpaceOrbit, x: Floats, p: Floats) -> SpaceOrbit:
    """The orbit of the same pieces with other points (n, d) and parameters (k,)."""
    return with_unknowns(orbit, np.concatenate((x.ravel(), p, (orbit.share,))))


def _share(x: float, inner: SpaceImage, outer: SpaceImage, otherwise: float) -> float:
    """The share s at which a point of the line lies between two limits."""
    jump = float(outer.value[0] - inner.value[0])
    return (x - float(inner.value[0])) / jump if jump else otherwise


def head_of(crossing: SpaceOrbit, unknowns: Floats) -> SpaceOrbit:
    """The points of a jump crossing up to the border at other unknowns, as an open orbit."""
    (n, d), k = crossing.x.shape, len(crossing.p)
    x, p = unknowns[: n * d].reshape(n, d), unknowns[n * d : n * d + k]
    pieces = [*(image.piece for image in crossing.images[:-1]), first_piece_of(crossing.images[-1])]
    head = orbit_of(pieces, x, p)
    if not head.images[-1].reason:
        return head
    # Rounding has put the point on the far side of a root singularity, where the path ends.
    inside = _first_limit(
        crossing.images[-1], crossing.x[-1], crossing.p, x[-1], p, may_be_smooth=True
    )
    return head if inside is None else head.with_image(n - 1, inside)


def completed(head: SpaceOrbit, crossing: SpaceOrbit) -> SpaceOrbit:
    """The jump crossing in R^1 with given points up to the border, and the pieces of another."""
    assert crossing.outer is not None
    x, p = head.x[-1], head.p
    images = [*head.images]
    last = crossing.images[-1].piece
    if isinstance(last, Chain):
        for piece in last.pieces[1:]:
            images.append(piece.at(images[-1].value, p))
        images = [*images[: len(head.x) - 1], chained(images[len(head.x) - 1 :])]
    outer = _at_border(crossing.outer, crossing.outer.piece.at(x, p), crossing, x, p)
    share = _share(float(head.x[0, 0]), images[-1], outer, crossing.share)
    return SpaceOrbit(head.x, p, share, tuple(images), outer)


def _at_border(
    before: SpaceImage, image: SpaceImage, crossing: SpaceOrbit, x: Floats, p: Floats
) -> SpaceImage:
    """A limit of a jump crossing; beside a root singularity that from inside the piece."""
    if image.has_small_slopes:
        return image
    at = crossing.x[-1], crossing.p, x, p
    return _inside(before, image, *at, may_be_smooth=not image.is_whole)


def _inside(
    before: SpaceImage, image: SpaceImage, x_before: Floats, p_before: Floats, x: Floats, p: Floats,
    *, may_be_smooth: bool,
) -> SpaceImage:  # fmt: skip
    """The image of a border point as the one-sided limit of its piece, if that exists."""
    first = _first_limit(before, x_before, p_before, x, p, may_be_smooth=may_be_smooth)
    if first is None:
        return image
    images = [first]
    for piece in before.piece.pieces[1:] if isinstance(before.piece, Chain) else ():
        if images[-1].reason:
            return image
        images.append(piece.at(images[-1].value, p))
    return image if images[-1].reason else chained(images)


def first_image_of(image: SpaceImage, x: Floats, p: Floats) -> SpaceImage:
    """The image of a border point under the first piece of a chain; at a root its limit there."""
    first = first_piece_of(image).at(x, p)
    limit_inside = _first_limit(image, x, p, x, p, may_be_smooth=True) if first.reason else None
    return limit_inside or first


def _first_limit(
    before: SpaceImage, x_before: Floats, p_before: Floats, x: Floats, p: Floats, *,
    may_be_smooth: bool,
) -> SpaceImage | None:  # fmt: skip
    """The one-sided limit of a piece (the first of a chain) at a point of its border, if any."""
    # Only the first piece of a chain ends at this border: the others start from its limit.
    tied = before.tied(x_before, p_before) & (before.codes % length_of(before) == 0)
    sizes, piece, d = before.sizes(x_before, p_before), first_piece_of(before), len(x)
    inward = before.gradients[tied.argmax()] * sizes if tied.any() else np.zeros(len(sizes))
    if len(p) == 1 or np.abs(inward[:d]).max() > DEPENDS * np.abs(inward).max():
        inward[d:] = 0.0  # the parameters need not change
    longest = float(np.abs(inward).max())
    if not 0.0 < longest < math.inf:  # far out on a path even finite event times may overflow
        return None
    unit = inward / longest * sizes
    if not may_be_smooth and root_of(piece, x, p, unit) is None:
        return None
    near = piece.at(x + INSIDE * unit[:d], p + INSIDE * unit[d:])
    return None if near.reason else limit(near, x, p, unit)
