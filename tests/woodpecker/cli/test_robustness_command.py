"""The command ``woodpecker robustness``."""

from pathlib import Path

import pytest
from commands import rows
from needs import SLOW_TOY
from typer.testing import CliRunner

from woodpecker.cli.app import app
from woodpecker.cli.robustness import FILES


@SLOW_TOY
def test_tables_on_screen_and_on_disk(tmp_path: Path) -> None:
    found = CliRunner().invoke(
        app, ["robustness", "--parameters", "eps_n1,mu_2", "--out", str(tmp_path)]
    )
    assert found.exit_code == 0
    output = " ".join(found.output.split())
    assert "All parameters at once" in output
    assert "0.18512695" in output
    located, limits = (rows(tmp_path / name) for name in FILES)
    assert float(located[0]["size"]) <= min(abs(float(each["percent"])) for each in limits) / 100.0
    assert located[0]["confirmed"] == "True"
    by_name = {(each["parameter"], each["direction"]): each for each in limits}
    # steps of Newton's method end at a hundred spacings of the parameter
    assert float(by_name["eps_n1", "1"]["value"]) == pytest.approx(0.64854920022763, abs=1e-12)
    assert float(by_name["eps_n1", "-1"]["value"]) == pytest.approx(0.18512695093092, abs=1e-12)
