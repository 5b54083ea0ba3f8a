"""The drawing: its points keep the gaps of the model, its animations their length."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.animation import FFMpegWriter
from matplotlib.figure import Figure
from PIL import Image

from woodpecker import Toy, Trajectory, shoot, simulate
from woodpecker.base.arrays import Floats
from woodpecker.mechanics.equations import gap_offsets, normal_directions, tangential_directions
from woodpecker.plot.drawing import (
    BODY,
    HOLD,
    TAIL,
    animate,
    bird,
    closed_contacts,
    draw_frames,
    draw_toy,
    frame_times,
    points,
    window,
)

ROUNDING = 1e-16  # m; a few spacings of doubles at the toy's size of some 0.02 m
OTHER = Toy(h_s=0.018, l_s=0.0195, l_g=0.0162, r_m=0.0033, h_m=0.007)


def coordinates(n: int = 40) -> Floats:
    """Coordinates the toy can have, and the corners of what it can have."""
    rng = np.random.default_rng(7)
    y, phi_m, phi_s = rng.uniform(-0.02, 0.02, n), rng.uniform(-0.1, 0.1, n), -rng.random(n)
    corners = [(0.0, m, s) for m in (-Toy().phi_m_max, Toy().phi_m_max) for s in (-0.5, 0.12)]
    return np.concatenate([np.column_stack([y, phi_m, phi_s]), corners])


@pytest.fixture(scope="module")
def motion() -> Trajectory:
    orbit = shoot(Toy(), -0.53)
    return simulate(Toy(), orbit.phi_s, orbit.period)


@pytest.mark.parametrize("toy", [Toy(), OTHER])
def test_beak_and_edges_are_as_far_from_the_pole_as_the_gaps_say(toy: Toy) -> None:
    offsets, directions = np.array(gap_offsets(toy)), np.array(normal_directions(toy))
    for q in coordinates():
        at, gaps = points(toy, q), offsets + directions @ q
        drawn = np.array([at.beak[0], at.lower[0], at.upper[0]]) - toy.r_0
        assert drawn == pytest.approx(gaps, rel=0.0, abs=50.0 * ROUNDING)
    _, left = points(toy, (0.0, -toy.phi_m_max, -0.5)).walls  # the edge across touches, too
    assert left[3, 0] == pytest.approx(-toy.r_0, abs=50.0 * ROUNDING)


def test_edges_move_along_the_pole_as_the_tangential_directions_say() -> None:
    toy, q = Toy(), np.array([0.004, -0.06, -0.3])
    at, path = points(toy, q), np.array(tangential_directions(toy)) @ q
    assert at.lower[1] + toy.h_m == pytest.approx(path[1], abs=50.0 * ROUNDING)
    assert at.upper[1] - toy.h_m == pytest.approx(path[2], abs=50.0 * ROUNDING)


def test_the_beak_moves_along_the_pole_to_first_order() -> None:
    """Only to first order, because the drawn bird turns and the model's only tilts."""
    toy, step = Toy(), 1e-6
    for k, w in enumerate(tangential_directions(toy)[0]):
        q = np.zeros(3)
        q[k] = step
        rise = (bird(toy, q, (0.0, 1.0)) - bird(toy, -q, (0.0, 1.0)))[1] / (2.0 * step)
        assert rise == pytest.approx(w, abs=1e-10)  # rounding over the step: 1e-17 / 1e-6


def test_the_bird_is_rigid_and_turns_by_its_angle() -> None:
    toy, here = Toy(), np.array([*BODY, *TAIL])
    rest = bird(toy, (0.0, 0.0, 0.0), here)
    for q in coordinates(10):
        moved = bird(toy, q, here)
        sides, kept = np.diff(moved, axis=0), np.diff(rest, axis=0)
        angle = np.angle((sides @ (1.0, 1j)) / (kept @ (1.0, 1j)))
        assert np.hypot(*sides.T) == pytest.approx(np.hypot(*kept.T), rel=1e-12)
        assert angle == pytest.approx(q[2], abs=1e-12)


def test_the_spring_holds_both_bodies() -> None:
    toy, q = Toy(), np.array([0.001, 0.05, -0.4])
    at = points(toy, q)
    outer = 0.5 * (at.walls[0, 1] + at.walls[0, 2])
    assert at.spring[0] == pytest.approx(outer, abs=50.0 * ROUNDING)
    assert at.spring[-1] == pytest.approx(bird(toy, q, HOLD), abs=50.0 * ROUNDING)


def test_the_window_holds_what_is_drawn() -> None:
    toy, rows = Toy(), coordinates()
    (left, right), (low, high) = window(toy, rows)
    drawn = np.concatenate([bird(toy, q, [*BODY, *TAIL, (0.0, 1.0)]) for q in rows])
    assert left < drawn[:, 0].min() < drawn[:, 0].max() < right
    assert low < drawn[:, 1].min() < drawn[:, 1].max() < high


def test_closed_contacts_follow_the_word(motion: Trajectory) -> None:
    """S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2 [Leine2001, Fig. 7]."""
    times = {event.symbol: event.time for event in reversed(motion.events)}
    assert closed_contacts(motion, 0.0) == (2,)
    assert closed_contacts(motion, times["D2"]) == (2,)
    assert closed_contacts(motion, times["D2"] + 1e-6) == ()
    assert closed_contacts(motion, times["I1"]) == (1,)
    assert closed_contacts(motion, times["I1"] + 1e-6) == ()
    assert closed_contacts(motion, times["I1"] + 1e-6, hold=1e-5) == (1,)
    assert closed_contacts(motion, 0.0495) == (3,)  # between the second I3 and its D3
    assert closed_contacts(motion, motion.t_end) == (2,)


def test_drawing_marks_what_it_is_told() -> None:
    ax = Figure().subplots()
    drawn = draw_toy(Toy(), (0.0, 0.0, 0.0), ax, closed=(3, 1), styles={"spring": {"color": "k"}})
    assert drawn.ax is ax
    assert [text.get_text() for text in ax.texts] == ["1", "3"]
    assert list(drawn.artists) == ["pole", "sleeve", "spring", "bird", "closed contacts"]
    assert {line.get_color() for line in drawn.artists["spring"]} == {"k"}
    with pytest.raises(ValueError, match=r"contacts are 1, 2 and 3, got \[4\]"):
        draw_toy(Toy(), (0.0, 0.0, 0.0), ax, closed=(4,))
    with pytest.raises(ValueError, match=r"a style must be of one of pole, .*, got 'wing'"):
        draw_toy(Toy(), (0.0, 0.0, 0.0), ax, styles={"wing": {}})


def test_drawing_on_its_own_is_in_metres() -> None:
    ax = draw_toy(Toy(), (0.0, 0.0, 0.0)).ax
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    assert 0.03 < right - left < high - low < 0.1  # a toy of some centimetres
    assert ax.get_ylabel() == "height [m]"


def test_frames_stand_side_by_side(motion: Trajectory) -> None:
    drawn = draw_frames(motion, [0.0, 0.02, 0.04, 0.06, 0.1], list("abcde"))
    axes = drawn.axes
    assert len(drawn.artists["bird"]) % 5 == 0
    assert [ax.get_title() for ax in axes] == list("abcde")
    assert len({(ax.get_xlim(), ax.get_ylim()) for ax in axes}) == 1
    with pytest.raises(ValueError, match="one label for each time, got 1 times, 2 labels"):
        draw_frames(motion, [0.0], ["a", "b"], Figure())


def test_frames_of_an_animation_last_as_long_as_the_motion_slowed() -> None:
    times = frame_times(0.1, 20.0, 25.0)
    assert len(times) == 50  # 0.1 s, 20 times slower, 25 each second
    assert times[0] == 0.0
    assert np.diff(times) == pytest.approx(0.1 / 50)
    with pytest.raises(ValueError, match=r"10000 frames, got slow = 1e\+09 times 0.1 s at 25"):
        frame_times(0.1, 1e9, 25.0)


@pytest.mark.nightly
@pytest.mark.parametrize(("fps", "milliseconds"), [(25.0, 40), (30.0, 30), (60.0, 20)])
def test_a_gif_has_its_frames_and_its_duration(
    tmp_path: Path, fps: float, milliseconds: int
) -> None:
    motion = simulate(Toy(), -0.53, 0.06)
    shares: list[float] = []
    path = animate(
        motion, tmp_path / "toy.gif", slow=5.0, fps=fps, size=(1.0, 1.4), progress=shares.append
    )
    with Image.open(path) as image:
        expected = round(0.06 * 5.0 * 1000.0 / milliseconds)
        assert image.n_frames == len(shares) == expected
        assert image.size == (100, 140)
        lasted = 0
        for k in range(image.n_frames):
            image.seek(k)
            lasted += image.info["duration"]
        assert lasted == expected * milliseconds
    assert [file.name for file in tmp_path.iterdir()] == ["toy.gif"]


def test_wrong_animations_get_one_sentence(
    motion: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(ValueError, match=r"a \.gif or an \.mp4, got 'toy\.avi'"):
        animate(motion, tmp_path / "toy.avi")
    with pytest.raises(ValueError, match="slow must be positive and finite, got 0"):
        animate(motion, tmp_path / "toy.gif", slow=0.0)
    monkeypatch.setattr(FFMpegWriter, "isAvailable", lambda: False)
    with pytest.raises(FileNotFoundError, match="needs ffmpeg"):
        animate(motion, tmp_path / "toy.mp4")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("frame", [1, 3])  # an end before the first one was an IndexError
def test_an_interrupted_animation_leaves_the_old_one(
    motion: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, frame: int
) -> None:
    old = tmp_path / "toy.gif"
    old.write_bytes(b"old")

    drawn: list[object] = []

    def interrupted(*arguments: object, closed: object) -> None:
        drawn.append(arguments)
        if len(drawn) == frame:
            raise KeyboardInterrupt

    monkeypatch.setattr("woodpecker.plot.drawing.draw_toy", interrupted)
    with pytest.raises(KeyboardInterrupt):
        animate(motion, old)
    assert old.read_bytes() == b"old"
    assert [file.name for file in tmp_path.iterdir()] == ["toy.gif"]
