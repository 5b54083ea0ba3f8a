"""The command ``woodpecker curves``."""

import csv
from pathlib import Path

from commands import invoked
from needs import SLOW_TOY

from pwmap import read_graph
from woodpecker.cli.app import app
from woodpecker.cli.curves import GRAPHS, PICTURE, TABLES

NEAR_A = ("--second-span", "0.298", "0.31")


def run(*arguments: str) -> tuple[int, str]:
    found = invoked(app, "curves", *arguments)
    return found.exit_code, " ".join(found.output.split())


@SLOW_TOY
def test_it_follows_a_and_c(tmp_path: Path) -> None:
    code, output = run("--from", "A,C", *NEAR_A, "--out", str(tmp_path))
    assert code == 0
    assert "jump closes" in output  # on the curve of C both limits lie on the diagonal once
    assert sorted(each.name for each in tmp_path.iterdir()) == sorted(
        [f"{PICTURE}.png", *TABLES, *GRAPHS, "about_curves.json"]
    )
    with (tmp_path / "curves.csv").open(encoding="utf-8") as lines:
        rows = list(csv.DictReader(lines))
    assert {row["curve"] for row in rows} == {"A", "C"}
    near = min(abs(float(r["eps_n1"]) - 0.11197091445663) for r in rows if r["mu_2"] == "0.3")
    assert near < 1e-12  # the last digit of the reference
    graph = read_graph(tmp_path / "curves.graphml")
    assert graph.number_of_edges() >= 2
    assert "expansion_friction" in graph.graph["toy"]
    assert graph.graph["program"].startswith("woodpecker-toy ")
    assert "JC" in {kind for _, kind in graph.nodes(data="kind")}
