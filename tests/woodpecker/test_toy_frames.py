"""Results of the toy as dataframes, and what a newcomer does with them in a few lines."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from same import differences

from woodpecker import (
    Toy,
    load_diagram,
    return_map,
    simulate,
    systems,
)
from woodpecker.examples import border_curve, bouncing_ball


def test_returns() -> None:
    """One start jams as the paper's motion does, the other falls for ever."""
    frame = return_map(Toy(), [-0.52947197, -1.225]).to_dataframe()
    assert list(frame.columns) == [
        "phi_s_start", "phi_s", "period", "drop", "slope", "d_eps_n1", "status", "word",
    ]  # fmt: skip
    first = frame.iloc[0]
    assert first.phi_s == pytest.approx(-0.52947197, abs=1e-8)
    assert first.period == pytest.approx(0.14597607, abs=1e-8)
    assert first["drop"] == pytest.approx(0.0194454, abs=1e-7)
    assert first.word == "S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2"
    assert frame.status.tolist()[0] == "returned"


def test_samples_and_events_of_a_motion() -> None:
    motion = simulate(Toy(), -0.53, 0.15, samples=31)
    frame, events = motion.to_dataframe(), motion.events_to_dataframe()
    assert list(frame.columns) == ["t", "y", "phi_m", "phi_s", "dy", "dphi_m", "dphi_s"]
    assert frame[["y", "phi_m", "phi_s"]].to_numpy().tolist() == motion.q.tolist()
    assert frame[["dy", "dphi_m", "dphi_s"]].to_numpy().tolist() == motion.u.tolist()
    assert " ".join(events.event) == motion.word
    beak = events[(events.what == "impact") & (events.contacts == "1")].iloc[0]
    assert beak.t == pytest.approx(0.048187, abs=1e-6)
    assert beak.dphi_s_before == motion.events[4].u_before[2]
    smooth = events[events.what != "impact"]
    assert smooth.dy_before.to_numpy() == pytest.approx(smooth.dy_after.to_numpy(), abs=1e-12)


def test_events_of_a_motion_without_any() -> None:
    events = simulate(Toy(), -0.22, 0.01, samples=3).events_to_dataframe()
    assert len(events) == 0
    assert "dphi_s_after" in events.columns


def test_a_curve_of_two_parameters() -> None:
    """A border collision of x -> r - a x at x = 0 stays at r = 0."""
    curve = border_curve(1.1)
    frame = curve.to_dataframe()
    assert list(frame.columns)[:3] == [*curve.names, "x_0"]
    assert len(frame) == len(curve)
    assert frame[curve.names[0]].abs().max() < 1e-12
    assert (frame[curve.names[1]].min(), frame[curve.names[1]].max()) == (1.1, 2.0)
    assert np.allclose(frame.gap.abs(), 2.0, atol=1e-12)
    assert set(frame.kind) == {"FF"}


# --- What a newcomer writes -----------------------------------------------------------------------

OWN_MAP = """
from pwmap.plot import plot_diagram
from woodpecker import FormulaMap, FormulaPiece, Smooth, bifurcation_diagram, load_diagram
low = FormulaPiece("low", Smooth(lambda x, p: p - 2), {"x is 0": Smooth(lambda x, p: -x)})
high = FormulaPiece("high", Smooth(lambda x, p: p - 1.25*x), {"x is 0": Smooth(lambda x, p: x)})
own = FormulaMap([low, high])
found = bifurcation_diagram(own, "p", (-0.5, 1.5), orders=(1, 2), window=(-3.0, 3.0))
found.named({"A": (0.0, 0.0)}).save("own.json")
plot_diagram(load_diagram("own.json"), words=True).figure.savefig("own.pdf")
"""


def run(text: str) -> dict[str, Any]:
    """The names that a program leaves behind."""
    names: dict[str, Any] = {}
    exec(text, names)
    return names


@pytest.mark.slow
def test_an_own_map_in_ten_lines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert len(OWN_MAP.split("\n")) - 2 <= 10
    monkeypatch.chdir(tmp_path)
    found, loaded = run(OWN_MAP)["found"], load_diagram("own.json")
    assert differences(found.named({"A": (0.0, 0.0)}), loaded) == []
    assert (tmp_path / "own.pdf").read_bytes().startswith(b"%PDF")
    assert loaded.point("A").kind == "FF"
    assert abs(loaded.point("A").parameter) < 1e-12
    assert {b.word for b in loaded.branches if b.kind == "fixed-point"} == {"low", "high"}
    assert {b.order for b in loaded.branches if b.kind == "jump"} == {1, 2}


def test_samples_and_events_of_a_motion_of_a_system() -> None:
    """A ball from 5 m under g = 10 strikes at t = 1 with 10 m/s; as a table and without events."""
    motion = systems.simulate(bouncing_ball(), {"y": 5.0}, 1.5, samples=11)
    frame = motion.to_dataframe()
    assert list(frame.columns) == ["t", "y", "u_y"]
    assert frame.to_numpy().tolist() == np.column_stack([motion.t, motion.q, motion.u]).tolist()
    (strike,) = motion.events_to_dataframe().itertuples()
    assert (strike.t, strike.event) == (pytest.approx(1.0, abs=1e-12), "I1")
    assert (strike.u_y_before, strike.u_y_after) == pytest.approx((-10.0, 5.0), abs=1e-11)
    free = systems.simulate(bouncing_ball(), {"y": 5.0}, 0.5).events_to_dataframe()
    assert (free.shape, list(free.columns)) == ((0, 4), ["t", "event", "u_y_before", "u_y_after"])
