"""Ways to follow a machine with impacts: what each of them converges to."""

from pathlib import Path

import numpy as np
import pytest
from needs import NEEDS_HEYOKA
from short_runs import is_picture, short_run

from studies.peers import pydstool_peer, siconos_peer
from studies.systems.peers import (
    Moreau,
    block,
    by_hand,
    by_pydstool,
    by_siconos,
    impact_oscillator,
    machines,
)

pytestmark = [NEEDS_HEYOKA, pytest.mark.slow]


def test_peers_on_systems(tmp_path: Path) -> None:
    found = short_run("system_peers", tmp_path)
    for name in ("oscillator", "block"):
        ways = found[name]
        assert ways["systems"]["error"][0] < 1e-13  # rounding of two flights
        assert max(ways["dop853"]["error"]) < 1e-3
        assert ways["dop853"]["error"][-1] < 1e-10
        assert ways["moreau"]["error"][-1] < 1e-2
    assert found["toy"]["systems"]["error"][0] < 1e-13
    if "pydstool" in found["oscillator"]:
        assert found["oscillator"]["pydstool"]["error"][-1] < 1e-9
        assert "PyDSTool" in machines({"system_peers": found})
    assert is_picture(tmp_path / "system_peers.png")
    assert "closed-form kernel" in machines({"system_peers": found})


def test_without_a_program_there_is_nothing_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    for peer in (pydstool_peer, siconos_peer):
        monkeypatch.setattr(peer, "PYTHON", "/nowhere/python3")
    assert by_pydstool(impact_oscillator()) == {}
    assert by_siconos(impact_oscillator(), [1e-2]) == {}


@pytest.mark.skipif(bool(pydstool_peer.available()), reason=pydstool_peer.available() or "runs")
def test_pydstool_converges() -> None:
    """Its events are as exact as its steps: the error falls with the tolerance to 1e-9 and less."""
    error = by_pydstool(impact_oscillator())["pydstool"]["error"]
    assert error[0] > 1e-6 > error[2] > error[-1]
    assert error[-1] < 1e-9


@pytest.mark.skipif(bool(siconos_peer.available()), reason=siconos_peer.available() or "runs")
def test_siconos_is_of_order_one_as_moreau_is() -> None:
    """An impact lies somewhere within a step, and is carried out at its end."""
    coarse, fine = by_siconos(impact_oscillator(), [8e-3, 2e-3])["siconos"]["error"]
    assert np.log(coarse / fine) / np.log(4.0) == pytest.approx(1.0, abs=0.35)
    assert fine < 1e-2


@pytest.mark.parametrize("problem", [impact_oscillator(), block()])
def test_moreau_is_of_order_one(problem) -> None:  # type: ignore[no-untyped-def]
    """The root mean square over neighbouring steps; where impacts fall within them is luck."""
    scheme, n, sizes = Moreau(problem.system), problem.system.n, []
    for step in (8e-3, 2e-3):
        ends = [
            scheme.follow(problem.start, problem.t_end, step * factor)[[0, n]]
            for factor in np.linspace(0.8, 1.2, 9)
        ]
        sizes.append(np.sqrt(np.mean(np.square(np.array(ends) - problem.exact))))
    assert np.log(sizes[0] / sizes[1]) / np.log(4.0) == pytest.approx(1.0, abs=0.35)
    assert np.abs(by_hand(problem, 1e-10) - problem.exact).max() < 1e-8
