"""Any system of contacts as a model of the explorer, from a file; no browser."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from woodpecker import Toy, shoot

pytest.importorskip("bokeh")
pytest.importorskip("heyoka")
from pwmap.explore.diagrams import summary
from woodpecker.explore import system_model as model
from woodpecker.explore.system_model import answers, diagram
from woodpecker.explore.system_state import (
    explored,
    first_state,
    from_query,
)
from woodpecker.systems import continuation
from woodpecker.systems import shoot as shoot_system

DOCS = Path(__file__).parents[3] / "docs" / "explore.md"
TOY = """
from studies.systems.toy import map_of
from woodpecker import Toy

map_ = map_of(Toy(), "eps_n1")
start, window = [-0.53], [(-2.5, 0.11)]
"""

RATTLE = """
import sympy

from woodpecker.systems import Contact, ContactSystem, Section, SystemMap

x, v, t, m, d, F, w, gap, eps = sympy.symbols("x u_x t m d F w gap eps")
flanks = [Contact(name="left", gap=gap + x, eps_n=eps),
          Contact(name="right", gap=gap - x, eps_n=eps)]
values = {m: 1.0, d: 0.1, F: 1.0, w: 1.0, gap: 0.5, eps: 0.6}
system = ContactSystem([x], [[m]], [F * sympy.cos(w * t) - d * v], flanks, values)
map_ = SystemMap(system, Section(when=sympy.sin(w * t), free=[x, v], at={t: 0}), ["F"])
start, window = [0.0, 0.5], [(-0.5, 0.5), (-3.0, 3.0)]
"""

# a beam that falls flat into a corner: how the floor and the wall share the impulses is open
CORNER = """
import sympy

from woodpecker.systems import Contact, ContactSystem, Section, SystemMap

x, y, a, v, vy, va = sympy.symbols("x y a u_x u_y u_a")
laws = {"mu": 0.3, "eps_n": 0.5}
ends = [Contact(name="left", gap=y - sympy.sin(a), slip=v + sympy.sin(a) * va, **laws),
        Contact(name="right", gap=y + sympy.sin(a), slip=v - sympy.sin(a) * va, **laws),
        Contact(name="wall", gap=3 - x - sympy.cos(a), slip=vy, **laws)]
values, fall = {"g": 10.0}, [0, -sympy.Symbol("g"), 0]
system = ContactSystem([x, y, a], sympy.diag(1, 1, sympy.Rational(1, 3)), fall, ends, values)
map_ = SystemMap(system, Section(when=-vy, free=[x, v], at={y: 1, vy: 0}))
start, window = [2 - 3 / 5**0.5, 3.0], [(-3.0, 2.0), (0.0, 5.0)]  # it falls for 1/sqrt(5) s
"""


@pytest.fixture(scope="module")
def stop(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The file that the docs show."""
    blocks = re.findall(r"```py\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    path = tmp_path_factory.mktemp("system") / "stop.py"
    path.write_text(next(block for block in blocks if "map_ =" in block), encoding="utf-8")
    return str(path)


@pytest.mark.slow
def test_the_toy_as_a_system_moves_as_the_toy_does(tmp_path: Path) -> None:
    """Two ways to the same motion; both have converged to rounding."""
    path = tmp_path / "toy.py"
    path.write_text(TOY, encoding="utf-8")
    state, message = model.settled(first_state(str(path)))
    assert message == ""
    orbit = shoot(Toy(), -0.53)
    assert state.x[0] == pytest.approx(orbit.phi_s, abs=1e-11)
    motion = model.motion(state)
    assert motion.numbers["period"] == pytest.approx(orbit.period, abs=1e-11)
    assert motion.numbers["multiplier"] == pytest.approx(orbit.multiplier, abs=1e-8)
    assert " ".join(mark.symbol for mark in motion.marks) == orbit.word
    assert motion.q[-1, 2] == pytest.approx(orbit.phi_s, abs=1e-10)
    first = next(model.curves(state))
    assert len(first.x) >= 17


@pytest.mark.slow
def test_answers_come_the_quick_ones_first(stop: str) -> None:
    (state, message), motion, orbit, curve = answers(first_state(stop))
    assert message == ""
    assert motion.numbers["period"] == pytest.approx(2.0 * np.pi / 2.8, abs=1e-12)  # of the force
    assert [mark.what for mark in motion.marks] == ["impact: the stop"]
    u = motion.u[:, 0]
    (k,) = np.flatnonzero((np.diff(motion.t) == 0.0) & (np.abs(np.diff(u)) > 1e-6))
    assert u[k + 1] == pytest.approx(-0.8 * u[k], rel=1e-12)  # eps of the file
    assert np.abs(orbit[0] - state.x).max() == 0.0
    assert curve.fixed.shape == (1, 2)
    assert not curve.stable[0]


def test_contacts_of_an_impact_whose_impulses_are_open(tmp_path: Path) -> None:
    """Its symbol has other numbers, too: an error of an index."""
    path = tmp_path / "corner.py"
    path.write_text(CORNER, encoding="utf-8")
    mark = model.motion(first_state(str(path))).marks[0]
    assert mark.symbol.startswith("I~")
    assert (mark.contacts, mark.what) == ((1, 2, 3), "impact: left and right and wall")


@pytest.mark.slow
def test_a_diagram_is_the_branches_connected_with_the_motion(stop: str, tmp_path: Path) -> None:
    narrow = tmp_path / "narrow.py"
    text = Path(stop).read_text(encoding="utf-8").replace("(6.0, 10.0)", "(7.5, 8.5)")
    narrow.write_text(text, encoding="utf-8")
    state = first_state(str(narrow))
    stages = list(diagram(state))
    assert [bool(each.message) for each in stages] == [True] * (len(stages) - 1) + [False]
    found = stages[-1].diagram
    line = found.branches[0]
    away = replace(state, x=(0.0, 9.0))  # a sample holds both coordinates, wherever the page is
    for k in (1, len(line) // 2):
        there, message = model.settled(away.at_sample(line, k))
        assert message == ""
        place = (float(line.x[k]), float(line.columns["u_x"][k]))
        assert there.x == pytest.approx(place, abs=1e-9)


@pytest.mark.nightly
def test_a_periodic_motion_is_looked_for_where_orbits_go(tmp_path: Path) -> None:
    """A tooth between two flanks: from this start Newton's method finds no motion."""
    path = tmp_path / "rattle.py"
    path.write_text(RATTLE, encoding="utf-8")
    first = first_state(str(path))
    assert not shoot_system(first.map_, first.x).success
    state, message = model.settled(first)
    assert message.endswith("this one is where orbits go")
    cycle = shoot_system(state.map_, state.x)
    assert cycle.success
    assert np.abs(cycle.x[0] - state.x).max() < 1e-9  # it is one already


def test_a_start_behind_a_wall_is_shown_with_a_sentence(tmp_path: Path) -> None:
    """The page kept the motion of the start before, and drew no map."""
    path = tmp_path / "rattle.py"
    path.write_text(RATTLE.replace("start, window = [0.0, 0.5]", "start, window = [0.75, 0.5]"))
    (_, message), motion, orbit, curve = answers(first_state(str(path)))
    inside = "the start penetrates 'right': its gap is -0.25"
    assert (motion.message, motion.numbers, motion.marks) == (inside, {}, ())
    assert message.endswith(f"{inside}; the start is kept")
    assert (motion.q.tolist(), motion.u.tolist()) == ([[0.75]] * 2, [[0.5]] * 2)
    assert (orbit.tolist(), curve.fixed.shape) == ([[0.75, 0.5]], (0, 2))


@pytest.mark.nightly
def test_what_was_not_followed_is_said(stop: str) -> None:
    """One branch of several: how many more begin is a part of the diagram."""
    map_ = explored(stop).map_
    cycle = shoot_system(map_, [-0.8, 2.0])
    window = explored(stop).window
    one, two = (
        continuation(map_, cycle, (6.0, 10.0), window, max_branches=most).diagram for most in (1, 2)
    )
    said = "given up after 1 branch, as many as allowed (max_branches): "
    assert one.about["left"].startswith(said)
    assert summary(one).startswith(f"1 branch, 2 points; {said}")
    assert len(two.branches) > len(one.branches)


def test_a_link_holds_every_bit(stop: str) -> None:
    first = first_state(stop)
    assert first.query() == ""
    state = replace(first.at({"F": 7.1, "eps": 1.0 / 3.0}), x=(0.1, -2.0 / 3.0), order=2,
                    periodic=False)  # fmt: skip
    assert from_query(stop, state.query()) == state
    other = first.with_axis("eps")
    assert (other.span, from_query(stop, other.query())) == ((0.5, 1.0), other)


@pytest.mark.parametrize(
    ("query", "sentence"),
    [
        ("at_F=__import__('os')", "at_F must be a number"),
        ("at_none=1", "unknown parameter 'none'"),
        ("x=1", "a start has 2 numbers"),
        ("x=inf,0", "must be finite"),
        ("over=none", "over must be one of w, F, eps, zeta, got 'none'"),
        ("order=9", "order must be one of"),
        ("steps=999", "steps must lie in"),
        ("coordinate=7", "coordinate must lie below 1"),
        ("focus=<b>", "focus must be one of"),
        ("nonsense=1", "unknown name in the link: 'nonsense'"),
        ("x" * 5000, "a link has at most"),
    ],
)
def test_a_link_that_is_none_is_refused_with_a_sentence(
    stop: str, query: str, sentence: str
) -> None:
    with pytest.raises(ValueError, match=sentence):
        from_query(stop, query)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (("map_ =", "other ="), "must define 'map_'"),
        (("start =", "begin ="), "must define 'start'"),
        (("start = [-0.8, 2.0]  #", "start = [1.0]  #"), "must have 2 entries.* got 1 and 2"),
        (('"eps": (0.5', '"none": (0.5'), "ranges of .* has 'none'"),
        (("(6.0, 10.0)", "(10.0, 6.0)"), "the range of F"),
        (("start = [-0.8, 2.0]  #", "start = 'none'  #"), "start must be real numbers, got 'none'"),
        (("(-8.0, 1.0)", "(-8.0, float('inf'))"), r"window must be finite, got \(-8.0, inf\)"),
        (("window = [(-8.0, 1.0), (-10.0, 10.0)]", "window = 5"), "window of .* must be a list"),
        (("ranges = {", "ranges = 5  # {"), "ranges of .* two ends for each name, got 5"),
    ],
)
def test_a_file_that_lacks_something_is_refused_with_a_sentence(
    stop: str, tmp_path: Path, change: tuple[str, str], sentence: str
) -> None:
    path = tmp_path / "wrong.py"
    path.write_text(Path(stop).read_text(encoding="utf-8").replace(*change), encoding="utf-8")
    with pytest.raises((TypeError, ValueError), match=sentence):
        explored(str(path))


def test_a_file_that_is_none_is_refused_with_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="there is no Python file"):
        explored(str(tmp_path / "missing.py"))
    path = tmp_path / "wrong.py"
    for text, sentence in (
        ("x = 1\nimport sympyy", r"line 2 of .*wrong\.py: ModuleNotFoundError: No module named"),
        ("raise SystemExit('bye')", r"line 1 of .*wrong\.py: SystemExit: bye$"),
        ("x = 1\0", r"wrong\.py: (SyntaxError|ValueError): source code "),
        ("x = 1\ny = (2", r"line 2 of .*wrong\.py: SyntaxError: '\(' was never closed"),
    ):
        path.write_text(text)
        with pytest.raises(ValueError, match=sentence):
            explored(str(path))
    path.write_text("map_, start, window = 1, [0], [(0, 1)]")
    with pytest.raises(TypeError, match=r"map_ of .* must be a SystemMap, got int"):
        explored(str(path))


@pytest.mark.slow
def test_lines_of_python_run(stop: str) -> None:
    state = first_state(stop).at({"F": 7.5})
    space: dict[str, Any] = {}
    exec(state.python().partition("found =")[0], space)
    assert space["cycle"].success
    assert space["system"].parameters[next(s for s in space["system"].parameters
                                           if str(s) == "F")] == 7.5  # fmt: skip
