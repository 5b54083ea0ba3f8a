"""Period, drop and functions of the user along branches."""

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from needs import NEEDS_NUMBA

from pwmap.diagrams.diagram import Branch, BranchKind, Diagram, PointKind, SpecialPoint
from pwmap.diagrams.tables import write_results
from woodpecker.branches import observables
from woodpecker.diagrams import continuation
from woodpecker.mechanics.toy import Toy
from woodpecker.shooting import shoot
from woodpecker.simulation.returns import first_return

P, X = (0.5, 0.6), (-0.5294719692871093, -0.5213)  # the first is the stable motion


@pytest.fixture
def diagram() -> Diagram:
    """A branch of cycles, of which only the first sample is one to rounding, and one of jumps."""
    branches = [
        Branch(
            id=name, kind=kind, order=1, word="w", parameter=np.array(P), x=np.array(X),
            multiplier=np.array([-0.8, -0.9]), ends=("EP1", "EP2"),
        )
        for name, kind in (("F1", BranchKind.FIXED_POINT), ("J1", BranchKind.JUMP))
    ]  # fmt: skip
    points = tuple(
        SpecialPoint(id=f"EP{k + 1}", kind=PointKind.EP, parameter=P[k], x=X[k], order=1)
        for k in range(2)
    )
    return Diagram(parameter_name="eps_n1", x_name="phi_s", branches=tuple(branches), points=points)


def test_period_drop_and_a_function(diagram: Diagram) -> None:
    found = observables(
        Toy(), diagram, "period", "drop", speed=lambda toy, x: _speed(toy, x), eps=_restitution
    )
    columns = found.branch("F1").columns
    for k, (p, x) in enumerate(zip(P, X, strict=True)):
        back = first_return(Toy(eps_n1=p), x)
        # sums of some ten phases, in another order
        assert columns["period"][k] == pytest.approx(back.period, rel=1e-14)
        assert columns["drop"][k] == pytest.approx(back.drop, rel=1e-14)
        assert columns["speed"][k] == back.drop / back.period
    assert columns["period"][0] == pytest.approx(0.14597607, abs=2e-8)  # its phi_S is rounded
    assert columns["drop"][0] == pytest.approx(19.4454e-3, abs=5e-8)
    assert columns["eps"].tolist() == list(P)
    assert all(np.isnan(values).all() for values in found.branch("J1").columns.values())
    assert diagram.branch("F1").columns == {}


def _speed(toy: Toy, phi_s: float) -> float:
    back = first_return(toy, phi_s)
    return back.drop / back.period


def _restitution(toy: Toy, _: float) -> float:
    return toy.eps_n1


def test_columns_of_files(diagram: Diagram, tmp_path: Path) -> None:
    write_results(observables(Toy(), diagram, "period"), tmp_path)
    with (tmp_path / "branches.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["period"] for row in rows[2:]] == ["nan", "nan"]
    period = first_return(Toy(eps_n1=P[0]), X[0]).period
    assert float(rows[0]["period"]) == pytest.approx(period, rel=1e-14)


def test_more_observables_are_added(diagram: Diagram) -> None:
    found = observables(Toy(), observables(Toy(), diagram, "period"), eps=_restitution)
    assert set(found.branch("F1").columns) == {"period", "eps"}


def test_columns_have_the_length_of_their_branch() -> None:
    with pytest.raises(ValueError, match="column 'period' must have a value for each of 1 samples"):
        Branch(
            id="F1", kind=BranchKind.FIXED_POINT, order=1, word="w", parameter=np.zeros(1),
            x=np.zeros(1), multiplier=np.zeros(1), ends=("a", "b"),
            columns={"period": np.zeros(2)},
        )  # fmt: skip


@NEEDS_NUMBA
def test_at_a_jump_where_a_branch_ends_values_are_those_of_the_branch() -> None:
    """The toy itself takes the return of the other side there, 0.1482 s instead of 0.3528 s."""
    toy = Toy(eps_n1=0.388)
    found = continuation(toy, shoot(toy, -0.886), span=(0.387, 0.39), orders=(1,))
    (end,) = [point for point in found.points if point.kind is PointKind.FF]
    assert end.parameter == pytest.approx(0.38834958888, abs=1e-10)
    near = Toy(eps_n1=end.parameter - 1e-8)
    inside = shoot(near, -0.88477384)
    assert inside.success
    (branch,) = [each for each in found.branches if each.kind is BranchKind.FIXED_POINT]
    k = int(np.abs(branch.parameter - end.parameter).argmin())
    x = branch.x.copy()
    x[k] += 1e-14  # what rounding may do: certainly on the other side of the border
    assert first_return(Toy(eps_n1=end.parameter), float(x[k])).period < 0.15
    found = replace(found, branches=(replace(branch, x=x),))
    (branch,) = observables(toy, found, "period", "drop").branches
    # 1e-8 before the end; both change by 13 s and 27 m per unit of eps_N1 there
    assert branch.columns["period"][k] == pytest.approx(inside.period, abs=1e-6)
    assert branch.columns["drop"][k] == pytest.approx(inside.drop, abs=1e-6)


def test_what_is_no_toy_is_refused() -> None:
    empty = Diagram(branches=(), points=(), parameter_name="eps_n1", x_name="phi_s")
    with pytest.raises(TypeError, match="toy must be"):
        observables("toy", empty, "period")  # type: ignore[arg-type]
