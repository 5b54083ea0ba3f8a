"""What a general continuation program makes of the return map, and how it is told."""

import json

import matplotlib.pyplot as plt
import pytest
from needs import NEEDS_NUMBA, SLOW_TOY

from studies.peers import pydstool_peer
from studies.peers.peer import LostError
from studies.peers.pydstool_peer import (
    Traced,
    available,
    draw,
    leaps,
    main,
    route,
    shown_of,
    trace,
)
from studies.run_all import RESULTS
from woodpecker import Toy, continuation, shoot

WHY_NOT = available()
needs_pydstool = pytest.mark.skipif(bool(WHY_NOT), reason=WHY_NOT or "runs")


@NEEDS_NUMBA
def test_points_are_told_by_the_branch_they_lie_on() -> None:
    toy = Toy(eps_n1=0.19)
    diagram = continuation(toy, shoot(toy, -0.73), "eps_n1", span=(0.18, 0.195))
    high, low = (
        next(b for b in diagram.branches if b.kind == "fixed-point" and b.ends.count(end))
        for end in ("BC1", "FF1")
    )
    points = [(b.parameter[k], b.x[k]) for b, k in ((high, 1), (high, 2), (low, 1))]
    ids = route(Traced((*points, (0.19, 0.0)), "", 0), diagram)
    assert ids == [high.id, low.id, ""]
    assert leaps(ids, diagram) == [[high.id, low.id]]  # a jump crossing lies between them
    picture = draw(Traced(tuple(points), "", 0), diagram)
    arrows = [text for text in picture.axes[0].texts if text.arrow_patch is not None]
    assert [tuple(arrow.xy) for arrow in arrows] == [points[2]]  # one leap, to the lower branch
    plt.close(picture)


def test_the_curve_of_the_picture_is_kept() -> None:
    kept = json.loads((RESULTS / "peer_pydstool.json").read_text(encoding="utf-8"))
    for run in kept["runs"]:
        assert (len(run["curve"]), run["curve"][-1]) == (run["points"], run["last"])
        assert run["curve"][0] == pytest.approx([0.5, -0.52947197], abs=1e-6)  # its tolerance
    shown = shown_of(kept)
    assert (len(shown.points), shown.asked) == (62, 2793)
    assert min(p for p, _ in shown.points) < 0.0  # it runs outside of the range


def test_a_missing_pydstool_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pydstool_peer, "PYTHON", "/nowhere/python3")
    assert "/nowhere/python3" in available()
    assert main(fast=True) == {"skipped": available()}
    with pytest.raises(LostError, match="cannot be asked for"):
        trace(Toy(), 0.02, forward=True)


@needs_pydstool
@SLOW_TOY
def test_a_general_program_leaps_over_a_jump_unseen() -> None:
    """Towards 0 it goes on beyond C, on the branch to A; towards 1 it stops where F2 ends."""
    down, up = main(fast=True)["runs"]
    assert down["route"][:2] == ["F1", "F3"]
    assert ["F1", "F3"] in down["leaps"]
    assert up["route"][:2] == ["F1", "F2"]
    assert up["leaps"] == []
    assert up["last"][0] == pytest.approx(0.7911249391, abs=1e-4)  # its tolerance, near the end
