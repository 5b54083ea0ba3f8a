"""What a prompt shows of motions and of diagrams of systems: a line or two."""

from sympy import symbols

from woodpecker.systems import Contact, ContactSystem, LineOfSystem, Section, SystemMap, simulate


def test_a_motion_is_shown_in_a_line() -> None:
    y, g = symbols("y g")
    ball = ContactSystem([y], [[1]], [-g], [Contact(name="floor", gap=y, eps_n=0.5)], {g: 10.0})
    motion = simulate(ball, {"y": 5.0}, 5.0, samples=11, backend="scipy")
    assert repr(motion).startswith("Motion(t=0 to ")
    assert "events 'C1'" in repr(motion)
    assert len(repr(motion)) < 120


def test_a_return_map_is_shown_in_a_line() -> None:
    y, g = symbols("y g")
    ball = ContactSystem([y], [[1]], [-g], [Contact(name="floor", gap=y, eps_n=0.5)], {g: 10.0})
    map_ = SystemMap(ball, Section(when="floor", free=["u_y"]), ("g",), backend="scipy")
    text = "SystemMap(u_y at 'floor', of 1 coordinate and 1 contact, over g=10)"
    assert repr(map_) == text
    assert repr(map_.holding(g=5.0)) == text.replace("10", "5")
    assert repr(LineOfSystem(map_)) == f"LineOfSystem({text})"
