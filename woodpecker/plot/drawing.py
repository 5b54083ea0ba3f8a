"""Drawings of the toy: one position, the frames of a motion [Leine2001, Fig. 7], an animation.

The distances of the beak and the sleeve's edges from the pole are the gaps g_N1, g_N2, g_N3 of the
model's linear kinematics [Leine2001, Eq. 8]. The sleeve is cut open along its axis. Lengths, also
l_G, l_S and h_S of the bird, are in metres and to scale.
"""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from scipy.interpolate import CubicSpline

from pwmap.diagrams.files import write_whole
from pwmap.plot import UNSTABLE
from pwmap.plot.drawn import Artists, Drawn, Styles, add, axes_for, figure_of, sized, styled
from woodpecker.base.arrays import Floats
from woodpecker.base.checks import instance, real_array
from woodpecker.mechanics.modes import OPEN, mode_states
from woodpecker.mechanics.toy import Toy
from woodpecker.simulation.trajectory import Trajectory
from woodpecker.simulation.words import IMPACTS

WALL = 0.45  # thickness of the sleeve's wall over its inner radius
COILS = 6
DPI = 100.0  # pixels per inch of an animation
SIZE, LARGEST = (3.0, 4.0), 40.0  # of its frames [inch]: default, and 4000 pixels at most
MOST_FRAMES = 10_000  # of an animation: 100 s to draw at 10 ms each, 400 s to watch at 25 per s
WOOD, GRAIN = "#ead7b7", "#a88a5c"
METAL, INSIDE = "#969696", "#d9d9d9"
DARK, CREAM, CREST = "#333333", "#f7f3e8", "#cb181d"
POLE, SLEEVE, SPRING, BIRD, CLOSED = "pole", "sleeve", "spring", "bird", "closed contacts"
PARTS = (POLE, SLEEVE, SPRING, BIRD, CLOSED)

# The bird from the side, in its own units of l_S across and h_S up: (0, 1) is the tip of the beak,
# (1, 0) the centre of mass.
BODY = (
    (0.36, 1.04), (0.43, 1.21), (0.60, 1.27), (0.77, 1.17), (0.87, 0.93), (1.06, 0.66),
    (1.24, 0.28), (1.32, -0.17), (1.27, -0.52), (1.08, -0.66), (0.86, -0.50), (0.72, -0.17),
    (0.66, 0.21), (0.64, 0.55), (0.52, 0.79), (0.40, 0.89),
)  # fmt: skip
BELLY = (
    (0.41, 0.89), (0.54, 0.90), (0.68, 0.72), (0.80, 0.42), (0.88, 0.05), (0.97, -0.31),
    (1.06, -0.60), (0.87, -0.50), (0.73, -0.17), (0.67, 0.21), (0.65, 0.55), (0.53, 0.79),
)  # fmt: skip
CHEEK = ((0.44, 0.96), (0.55, 1.06), (0.72, 1.02), (0.76, 0.92), (0.62, 0.88), (0.50, 0.89))
CAP = ((0.50, 1.215), (0.60, 1.275), (0.77, 1.175), (0.835, 1.01), (0.75, 1.06), (0.62, 1.17))
TAIL = ((1.31, -0.30), (1.53, -1.22), (1.42, -1.17), (1.35, -1.26), (1.00, -0.55))
BEAK = ((0.0, 1.0), (0.39, 1.10), (0.38, 0.91))
BARS = tuple(
    ((1.02 + 0.04 * k, 0.36 - 0.26 * k), (1.25 + 0.02 * k, 0.24 - 0.27 * k)) for k in range(3)
)  # stripes on the wing
EYE = (0.555, 1.125)
HOLD = (0.69, -0.02)  # end of the spring, on the belly


class Points(NamedTuple):
    """Points of the drawing [m]; x runs from the pole's axis towards the bird, y upward."""

    beak: Floats  # (2,): contact 1
    lower: Floats  # (2,): contact 2
    upper: Floats  # (2,): contact 3
    walls: Floats  # (2, 4, 2), corners of the sleeve's walls: right, left
    spring: Floats  # (n, 2)


def points(toy: Toy, q: npt.ArrayLike) -> Points:
    """The points of the drawing at coordinates q = (y, phi_M, phi_S)."""
    # The sleeve moves by the linear kinematics (x, y) -> (x - phi_M y, y + phi_M x), which differ
    # from a rotation by half a percent at 0.1 rad. The bird is rotated about its end of the spring
    # and shifted in x until its beak has the distance r_0 + g_N1 from the axis.
    y, phi_m, _ = np.asarray(q, dtype=float)
    r, h, outer = toy.r_m, toy.h_m, (1.0 + WALL) * toy.r_m
    right = np.array([(r, -h), (outer, -h), (outer, h), (r, h)])
    walls = np.stack([right, right * (-1.0, 1.0)])
    turn, lift = np.array([(1.0, phi_m), (-phi_m, 1.0)]), np.array([0.0, y])
    walls = walls @ turn + lift
    start = np.array([outer, 0.0]) @ turn + lift
    return Points(
        beak=bird(toy, q, (0.0, 1.0)),
        lower=walls[0, 0],
        upper=walls[0, 3],
        walls=walls,
        spring=_coil(start, bird(toy, q, HOLD), np.asarray(q, dtype=float)[1:], 0.3 * toy.h_m),
    )


def bird(toy: Toy, q: npt.ArrayLike, shape: npt.ArrayLike) -> Floats:
    """Points (..., 2) of the bird [m] at coordinates q, from a shape in the bird's own units."""
    y, phi_m, phi_s = np.asarray(q, dtype=float)
    cosine, sine = math.cos(phi_s), math.sin(phi_s)
    turn = np.array([(cosine, sine), (-sine, cosine)])
    tip = np.array([toy.l_g - toy.l_s, toy.h_s])  # of the beak, from the end of the spring
    # by Eq. 8 r_0 + g_N1 = l_M + (l_G - l_S) - h_S phi_S
    across = toy.l_m + tip[0] - tip[1] * phi_s - (tip @ turn)[0]
    own = (np.asarray(shape, dtype=float) - (0.0, 1.0)) * (toy.l_s, toy.h_s) + tip
    placed: Floats = own @ turn + (across, y + toy.l_m * phi_m)
    return placed


def _coil(start: Floats, end: Floats, angles: Floats, radius: float) -> Floats:
    """A coil spring (n, 2) that is perpendicular to both bodies at its ends."""
    s = np.linspace(0.0, 1.0, 60 * COILS)[:, None]
    reach = float(np.hypot(*(end - start)))
    out, back = (reach * np.array([math.cos(a), math.sin(a)]) for a in angles)
    bend = s**2 * (3.0 - 2.0 * s)  # cubic Hermite interpolation of ends and directions
    line = (1.0 - bend) * start + bend * end
    line += s * (1.0 - s) * ((1.0 - s) * out - s * back)
    along = np.gradient(line, axis=0)
    normal = np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(*along.T)[:, None]
    inner = np.clip((s - 0.08) / 0.84, 0.0, 1.0)  # straight ends
    swing = np.sin(2.0 * math.pi * COILS * inner)
    coil: Floats = line + radius * swing * normal
    return coil


def draw_toy(
    toy: Toy, q: npt.ArrayLike, ax: Axes | None = None, *, closed: Iterable[int] = (),
    styles: Styles | None = None,
) -> Drawn:  # fmt: skip
    """Draw pole, sleeve, spring and bird at q = (y [m], phi_M [rad], phi_S [rad]).

    Parameters
    ----------
    toy, q
        The toy and its coordinates, shape (3,).
    ax
        Axes in metres, whose limits the caller sets; by default new ones that hold the whole toy.
    closed
        Contacts to mark: 1 beak, 2 lower edge of the sleeve, 3 upper edge. The opposite edge, which
        then also touches the pole, is no contact of the model.
    styles
        Properties of matplotlib by ``"pole"``, ``"sleeve"``, ``"spring"``, ``"bird"`` and
        ``"closed contacts"``.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type, or there is no such contact.

    Examples
    --------
    >>> from woodpecker import Toy
    >>> from woodpecker.plot.drawing import draw_toy
    >>> sorted(draw_toy(Toy(), (0.0, -0.05, -0.5), closed=[2]).artists)
    ['bird', 'closed contacts', 'pole', 'sleeve', 'spring']
    """
    instance("toy", toy, Toy)
    q = real_array("q", q)
    if q.shape != (3,):
        raise ValueError(f"q must be y, phi_M and phi_S, of shape (3,), got {q.shape}")
    marked = sorted(set(closed))
    if not set(marked) <= {1, 2, 3}:
        raise ValueError(f"contacts are 1, 2 and 3, got {marked}")
    if ax is None:
        ax = axes_for(None, 3.0, 4.0)
        x_limits, y_limits = window(toy, q)
        ax.set(xlim=x_limits, ylim=y_limits, xlabel="from the axis [m]", ylabel="height [m]")
    at = points(toy, q)
    right, left = at.walls
    shown: Artists = {
        POLE: _pole(toy, ax),
        SLEEVE: [
            _patch(ax, np.array([left[0], right[0], right[3], left[3]]), INSIDE, zorder=0.9),
            *(_patch(ax, wall, METAL, zorder=3.0) for wall in at.walls),
        ],
        SPRING: [
            *ax.plot(*at.spring.T, color="white", linewidth=2.4, zorder=3.1),
            *ax.plot(*at.spring.T, color=DARK, linewidth=0.8, zorder=3.2),
        ],
        BIRD: _bird(toy, q, ax),
    }
    for contact in marked:
        add(shown, {CLOSED: _mark(ax, (at.beak, at.lower, at.upper)[contact - 1], contact)})
    styled(shown, styles, PARTS)
    ax.set_aspect("equal")
    return Drawn((ax,), shown)


def _pole(toy: Toy, ax: Axes) -> list[Artist]:
    sides = (-toy.r_0, toy.r_0)
    return [
        ax.axvspan(*sides, facecolor=WOOD, edgecolor="none", zorder=1.0),
        *(ax.axvline(x, color=GRAIN, linewidth=0.7, zorder=1.1) for x in sides),
    ]


def _bird(toy: Toy, q: npt.ArrayLike, ax: Axes) -> list[Artist]:
    """Draw the bird, from back to front."""
    drawn: list[Artist] = []
    for shape, color, smooth, zorder in (
        (TAIL, DARK, False, 4.0),
        (BEAK, METAL, False, 4.1),
        (BODY, DARK, True, 4.2),
        (BELLY, CREAM, True, 4.3),
        (CHEEK, CREAM, True, 4.4),
        (CAP, CREST, True, 4.5),
    ):
        outline = _rounded(shape) if smooth else shape
        drawn.append(_patch(ax, bird(toy, q, outline), color, zorder))
    for bar in BARS:
        ends = bird(toy, q, bar).T
        drawn += ax.plot(*ends, color=CREAM, linewidth=1.3, solid_capstyle="round", zorder=4.6)
    eye = bird(toy, q, EYE)
    drawn += ax.plot(*eye, "o", color=DARK, mec=CREAM, mew=0.7, markersize=2.6, zorder=4.7)
    return drawn


def _rounded(corners: npt.ArrayLike) -> Floats:
    """The smooth closed curve through some points, (n, 2)."""
    closed = np.concatenate([corners, np.asarray(corners)[:1]])
    length = np.cumsum(np.hypot(*np.diff(closed, axis=0, prepend=closed[:1]).T))
    curve: Floats = CubicSpline(length, closed, bc_type="periodic")(
        np.linspace(0.0, length[-1], 12 * len(closed))
    )
    return curve


def _patch(ax: Axes, outline: Floats, color: str, zorder: float) -> Artist:
    shape = Polygon(outline, facecolor=color, edgecolor=DARK, lw=0.6, zorder=zorder)
    return ax.add_patch(shape)


def _mark(ax: Axes, place: Floats, contact: int) -> list[Artist]:
    """Ring a closed contact and write its number: below the lower edge, above the others."""
    ring = ax.plot(*place, "o", mfc="none", mec=UNSTABLE, mew=1.4, markersize=8.0, zorder=6.0)
    number = ax.annotate(
        str(contact), tuple(place), (0.0, -11.0 if contact == 2 else 11.0),
        textcoords="offset points", color=UNSTABLE,
        fontsize=sized(9), fontweight="bold", ha="center", va="center", zorder=6.1,
    )  # fmt: skip
    return [*ring, number]


# --- A motion -------------------------------------------------------------------------------------


def closed_contacts(trajectory: Trajectory, t: float, *, hold: float = 0.0) -> tuple[int, ...]:
    """Contacts that are closed or change at time t, or had an impact in the last ``hold`` [s]."""
    row = int(np.searchsorted(trajectory.phases[:, 6], t, side="right")) - 1
    states = mode_states(int(trajectory.phases[max(row, 0), 7]))
    closed = {k for k, state in enumerate(states, start=1) if state != OPEN}
    for event in trajectory.events:
        if event.time == t or (event.kind in IMPACTS and t - hold <= event.time <= t):
            closed |= set(event.contacts)
    return tuple(sorted(closed))


def window(toy: Toy, q: npt.ArrayLike) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits of x and y [m] that hold the toy at all coordinates q, shape (n, 3)."""
    rows = np.atleast_2d(np.asarray(q, dtype=float))
    shapes = (*BODY, *TAIL, (0.0, 1.0))
    seen = np.concatenate([np.concatenate([bird(toy, row, shapes), *points(toy, row).walls])
                           for row in rows])  # fmt: skip
    (left, low), (right, high) = seen.min(axis=0), seen.max(axis=0)
    edge = 0.05 * (high - low)
    return (left - edge, right + edge), (low - edge, high + edge)


def draw_frames(
    trajectory: Trajectory, times: Sequence[float] | Floats, labels: Sequence[str],
    figure: Figure | None = None, *, styles: Styles | None = None,
) -> Drawn:  # fmt: skip
    """Draw the toy at some instants side by side, all to the same scale [Leine2001, Fig. 7].

    Parameters
    ----------
    trajectory
        The motion.
    times, labels
        Instants [s], and the text above each frame.
    figure
        The figure to fill, by default a new one, with at most four frames in a row.
    styles
        As for :func:`draw_toy`.

    Raises
    ------
    TypeError, ValueError
        If it is no trajectory, times are empty, or there is not one label for each.

    Examples
    --------
    >>> from woodpecker import Toy, simulate
    >>> from woodpecker.plot.drawing import draw_frames
    >>> motion = simulate(Toy(), -0.52947197, 0.14597607, samples=201)
    >>> len(draw_frames(motion, [0.0, 0.05], ["at rest", "later"]).axes)
    2
    """
    instance("trajectory", trajectory, Trajectory)
    if not len(times) or len(times) != len(labels):
        raise ValueError(f"one label for each time, got {len(times)} times, {len(labels)} labels")
    columns = min(4, len(times))
    rows = math.ceil(len(times) / columns)
    if figure is None:
        figure = figure_of(1.9 * columns, 3.5 * rows)
    axes = list(figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).flat)
    q, _ = trajectory.at(np.asarray(times))
    x_limits, y_limits = window(trajectory.toy, q)
    shown: Artists = {}
    for ax, t, row, label in zip(axes, times, q, labels, strict=False):
        drawn = draw_toy(trajectory.toy, row, ax, closed=closed_contacts(trajectory, t))
        add(shown, drawn.artists)
        ax.set(xlim=x_limits, ylim=y_limits)
        ax.set_title(label, fontsize=sized(9))
        ax.tick_params(labelsize=sized(8))
        ax.grid(axis="y", alpha=0.25, linewidth=0.5)
    for ax in axes[len(times) :]:
        ax.set_visible(False)
    for ax in axes[::columns]:
        ax.set_ylabel("height [m]")
    for ax in axes[-columns:]:
        ax.set_xlabel("from the axis [m]")
    styled(shown, styles, PARTS)
    return Drawn(tuple(axes[: len(times)]), shown)


def frame_times(t_end: float, slow: float, fps: float) -> Floats:
    """Instants [s] of the frames of ``slow * t_end`` seconds; ValueError if they are too many."""
    count = max(1.0, t_end * slow * fps)
    if not count <= MOST_FRAMES:
        raise ValueError(
            f"an animation has at most {MOST_FRAMES} frames, got slow = {slow:g} times {t_end:g} s "
            f"at {fps:g} frames per second"
        )
    return np.arange(round(count)) / (slow * fps)


def animate(
    trajectory: Trajectory,
    path: str | os.PathLike[str],
    *,
    slow: float = 40.0,
    fps: float = 25.0,
    size: tuple[float, float] = SIZE,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Write the motion as an animation: GIF, or MP4 where ffmpeg is installed.

    The picture moves down the pole at the toy's mean speed. Impacts stay marked for 1/6 s.

    Parameters
    ----------
    trajectory
        The motion, from 0 to its end.
    path
        File to write, ``.gif`` or ``.mp4``; it is written completely or not at all.
    slow, fps
        How many times slower than real time; frames per second, for a GIF rounded so that a frame
        lasts whole hundredths of a second.
    size
        Width and height [inch], at 100 pixels per inch; at most 40 inches.
    progress
        Called after each frame with the fraction done.

    Raises
    ------
    TypeError, ValueError
        If it is no trajectory, ``slow``, ``fps`` or ``size`` is not positive, there would be more
        than 10 000 frames or a larger picture, or the suffix is neither.
    FileNotFoundError
        If an MP4 needs ffmpeg, which is not installed, or the folder does not exist.

    Examples
    --------
    >>> from woodpecker import Toy, simulate
    >>> from woodpecker.plot.drawing import animate
    >>> motion = simulate(Toy(), -0.52947197, 0.01, samples=11)
    >>> animate(motion, "toy.gif", slow=10.0).name
    'toy.gif'
    """
    instance("trajectory", trajectory, Trajectory)
    path = Path(path)
    writer, rate = film_writer(path, slow, fps, size)
    times = frame_times(trajectory.t_end, slow, rate)
    figure = Figure(figsize=size, dpi=DPI)
    ax = figure.add_axes((0.23, 0.03, 0.74, 0.9))  # fixed: a layout engine would shift frames
    q, _ = trajectory.at(times)
    ends, _ = trajectory.at([0.0, trajectory.t_end])
    camera = np.interp(times, [0.0, trajectory.t_end], ends[:, 0])
    x_limits, y_limits = window(trajectory.toy, q - camera[:, None] * (1.0, 0.0, 0.0))
    with tempfile.TemporaryDirectory() as folder:
        draft = Path(folder) / path.name
        writer.setup(figure, str(draft), DPI)
        try:
            for k, (t, row, height) in enumerate(zip(times, q, camera, strict=True), start=1):
                ax.clear()
                closed = closed_contacts(trajectory, float(t), hold=1.0 / (6.0 * slow))
                draw_toy(trajectory.toy, row, ax, closed=closed)
                ax.set(xlim=x_limits, ylim=(y_limits[0] + height, y_limits[1] + height))
                ax.set_title(f"{1e3 * t:.2f} ms, {slow:g} times slower", fontsize=sized(9))
                ax.set_ylabel("height [m]", fontsize=sized(8))
                ax.tick_params(labelsize=sized(7))
                ax.set_xticks([])
                writer.grab_frame()
                if progress is not None:
                    progress(k / len(times))
        except BaseException:
            if not isinstance(writer, PillowWriter):  # the process of ffmpeg ends
                writer.finish()
            raise
        writer.finish()
        write_whole(path, draft.read_bytes())
    return path


def film_writer(
    path: Path, slow: float, fps: float, size: tuple[float, float] = SIZE
) -> tuple[Any, float]:
    """The writer for a path's suffix, and its frame rate; errors as in :func:`animate`."""
    for name, value in (("slow", slow), ("fps", fps)):
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} must be positive and finite, got {value}")
    if not all(0.0 < each <= LARGEST for each in size):
        width, height = size
        raise ValueError(
            f"size must be a width and a height of at most {LARGEST:g} inches, got {width} {height}"
        )
    suffix = path.suffix.lower() if path.stem.strip(".") else ""
    if suffix == ".gif":
        rate = 100.0 / max(2, round(100.0 / fps))
        below = rate * (1.0 - 1e-9)  # the writer truncates 1000 / fps to whole ms
        return PillowWriter(fps=below), rate  # type: ignore[arg-type]
    if suffix != ".mp4":
        raise ValueError(f"an animation is a .gif or an .mp4, got {path.name!r}")
    if not FFMpegWriter.isAvailable():
        raise FileNotFoundError("an .mp4 needs ffmpeg, which was not found: choose a .gif")
    return FFMpegWriter(fps=fps), fps  # type: ignore[arg-type]
