"""The command ``pwmap analyse``, run in this process."""

import csv
import json
import subprocess
import sys
from pathlib import Path

import pytest
from commands import analyse as run
from matplotlib.figure import Figure
from typer.testing import CliRunner

import pwmap
from pwmap import check_certificate, read_graph
from pwmap.cli.analysis import Analysis
from pwmap.cli.app import app
from pwmap.diagrams import files
from pwmap.plane import load_plane, load_raster

P1L = "Piecewise((r - 2, x <= 0), (r - a*x, True))"


@pytest.mark.parametrize("there", [True, False])
def test_a_certificate_goes_into_a_folder_under_its_usual_name(there: bool, tmp_path: Path) -> None:
    folder = tmp_path / "results"
    if there:
        folder.mkdir()
    values = ["--set", "a=5/4", "--set", "r=1"]
    found = CliRunner().invoke(app, ["prove", P1L, *values, "--out", str(folder)])
    assert found.exit_code == 0
    assert found.output.endswith(f"wrote {folder / 'certificate.json'}\n")
    assert check_certificate(folder / "certificate.json").startswith("For the map")


@pytest.mark.nightly
def test_the_example_of_the_help_prints_and_writes_everything(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "folder"
    code, text = run(P1L, "--parameter", "r", "--set", "a=5/4", "--orders", "1,2,3", out=folder)
    assert code == 0
    for part in ("fold-flip", "border collision, fold", "4*r/9", "RR|RL", "r in (0, 10)", "50/21"):
        assert part in text
    assert (folder / "diagram.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    graph = read_graph(folder / "graph.graphml")
    assert graph.nodes["FF1"]["parameter_exact"] == "0"
    assert {data["x_exact"] for *_, data in graph.edges(data=True)} >= {"4*r/9", "r - 2", "4*r/5"}
    assert json.loads((folder / "graph.json").read_text())["nodes"]
    lines = (folder / "points.csv").read_text().splitlines()
    assert lines[0] == (
        "id,name,kind,r,x,order,note,cause,status,precision,interval_min,interval_max,branches,"
        "parameter_exact,x_exact"
    )
    assert (
        "BC4,,BC,2.380952380952381,0.0,3,fold,a point of a cycle meets the border x = 0,located,"
        "0.0,,,F3 J5,50/21,0"
    ) in lines
    assert "a fixed point meets the border x = 0" in " ".join(text.replace("│", " ").split())


@pytest.mark.nightly
def test_each_order_has_a_picture_of_its_own(tmp_path: Path) -> None:
    one, two = tmp_path / "one", tmp_path / "two"
    options = (P1L, "--parameter", "r", "--set", "a=5/4", "--span", "-1", "3", "--format", "pdf")
    code, text = run(*options, "--orders", "1,2", out=two)
    assert code == 0
    names = ["diagram.pdf", "order_1.pdf", "order_2.pdf"]
    assert sorted(path.name for path in two.glob("*.pdf")) == names
    assert all(name in text for name in names)
    assert all((two / name).read_bytes().startswith(b"%PDF-") for name in names)
    assert run(*options, "--orders", "1", out=one)[0] == 0
    assert [path.name for path in one.glob("*.pdf")] == names[:1]
    assert run(*options, "--orders", "1,2", out=one)[0] == 0  # the same picture is the same file
    assert (one / "order_2.pdf").read_bytes() == (two / "order_2.pdf").read_bytes()


@pytest.mark.slow
def test_pictures_say_their_iterate_and_at_which_values_they_are_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    titles = {}

    def keep(path: Path, figure: Figure) -> None:
        titles[path.name] = figure.axes[0].get_title()
        path.touch()

    monkeypatch.setattr(files, "write_figure", keep)
    span = ("--parameter", "r", "--span", "-1", "5/2")
    assert run(P1L, *span, "--given", "a > 1", "--sample", "a=2", out=tmp_path)[0] == 0
    assert titles["diagram.png"] == "drawn at a = 2"
    assert run(P1L, *span, "--set", "a=2", "--orders", "1,2", out=tmp_path)[0] == 0
    assert titles == {"diagram.png": "", "order_1.png": "$P_{1}$", "order_2.png": "$P_{2}$"}


TWO = ("Piecewise((a*x + r, x <= 0), (b*x + r - 2, True))", "--parameter", "r")


@pytest.mark.nightly
def test_two_parameters_stay_symbolic_around_a_sample(tmp_path: Path) -> None:
    """By default around one that the assumptions admit, which is told by what is given."""
    code, text = run(*TWO, "--given", "a > 0", "--given", "a < 1", out=tmp_path)
    assert code == 0
    assert "-r/(a - 1)" in text
    code, text = run(*TWO, "--sample", "a=1/2", "--sample", "b=-13/7", out=tmp_path)
    assert code == 0
    assert "given: a > 0, a < 1, b < -1, a*b > -1, b > -3" in " ".join(text.split())
    code, text = run(*TWO, "--sample", "a=1/2", out=tmp_path)
    assert code == 2
    assert "a sample must give values to ['a', 'b'], got ['a']" in text
    code, text = run(*TWO, "--sample", "a", out=tmp_path)
    assert code == 2
    assert "--sample needs name=value, such as a=5/4, got 'a'" in text
    code, text = run(*TWO, "--sample", "a=1", "--sample", "b=1", out=tmp_path)
    assert code == 2
    assert "at a = 1, b = 1 edges meet by chance: choose another sample" in text


def test_a_computation_without_memory_is_told_in_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(Analysis, "follow", full)
    code, text = run(P1L, "--parameter", "r", "--set", "a=2", out=tmp_path / "out")
    assert (code, text) == (1, "Failed: no memory is left\n")
    assert not (tmp_path / "out").exists()
    monkeypatch.undo()
    monkeypatch.setattr(Analysis, "draw", full)
    code, text = run(P1L, "--parameter", "r", "--set", "a=2", out=tmp_path / "out")
    assert code == 1
    assert "Failed: no memory is left; what was finished is kept, without pictures\n" in text
    assert (tmp_path / "out" / "diagram.json").exists()
    monkeypatch.setattr(pwmap, "check_certificate", full)
    found = CliRunner().invoke(app, ["check", "lines.json"])
    assert (found.exit_code, found.output) == (
        1, "Failed: no memory is left while lines.json was checked\n",
    )  # fmt: skip


@pytest.mark.nightly
def test_the_long_run_adds_tables_files_and_pictures(tmp_path: Path) -> None:
    tent = "Piecewise((a*x, x <= 1/2), (a*(1 - x), True))"
    options = ("--parameter", "a", "--span", "5/4", "9/4", "--orders", "1,2")
    code, text = run(tent, *options, "--attractors", "--density", "2", out=tmp_path)
    assert code == 0
    for part in ("merging crisis", "sqrt(2)", "final crisis", "1 band: [0, 1]", "log(2)", "LR(L)"):
        assert part in text
    lines = (tmp_path / "crises.csv").read_text().splitlines()
    assert lines[1].startswith("MC,1.4142135623730951,sqrt(2),2,1,R,")
    for name in ("diagram.png", "density_2.png"):
        assert (tmp_path / name).read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert (tmp_path / "attractors.csv").read_text().count("\n") == 5  # 2, 1 and 0 bands


@pytest.mark.nightly
def test_the_long_run_lists_intervals_of_constant_entropy(tmp_path: Path) -> None:
    skew = "Piecewise((x/2 + 1, x <= 0), (b*x + 1, True))"
    options = ("--parameter", "b", "--span=-5", "-1", "--orders", "1")
    code, _ = run(skew, *options, "--entropy", out=tmp_path)
    assert code == 0
    assert (tmp_path / "entropy.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    with (tmp_path / "entropy.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    shown = [(row["lower_exact"], row["upper_exact"], row["entropy_exact"], row["cycles"])
             for row in rows]  # fmt: skip
    assert shown == [("-5", "-4", "", ""), ("-4", "-3", "log(1/2 + sqrt(5)/2)", "LLR"),
                     ("-3", "-2", "", ""), ("-2", "-1", "0", "LR")]  # fmt: skip
    assert rows[1]["entropy"].startswith("0.48121182505960")
    assert rows[0]["open_because"].startswith("orbits of breaks are not known to the end")


@pytest.mark.slow
def test_the_table_of_attractors_names_neutral_intervals(tmp_path: Path) -> None:
    """1 - x turns (0, 1) about its middle, and all orbits come there; no density at two values."""
    map_ = "Piecewise((x/2 + p, x <= 0), (1 - x, x < 1), (x/2, True))"
    options = ("--parameter", "p", "--span", "1/4", "3/4", "--orders", "1")
    densities = ("--density", "1/3", "--density", "2/3")
    code, text = run(map_, *options, "--attractors", *densities, out=tmp_path)
    assert code == 1
    for value in ("1/3", "2/3"):
        assert f"at p = {value} no chaotic attractor has a density" in text
    with (tmp_path / "attractors.csv").open(newline="") as file:
        (row,) = csv.DictReader(file)
    assert (row["cycles"], row["neutral"], row["open"]) == ("", "M", "")
    assert (row["band"], row["from"], row["to"]) == ("", "", "")


@pytest.mark.slow
def test_a_run_leaves_nothing_of_an_earlier_one(tmp_path: Path) -> None:
    tent = "Piecewise((a*x, x <= 1/2), (a*(1 - x), True))"
    options = ("--parameter", "a", "--span", "5/4", "9/4", "--orders", "1")
    assert run(tent, *options, "--attractors", "--density", "2", out=tmp_path)[0] == 0
    before = {path.name for path in tmp_path.iterdir()}
    code, text = run(tent, *options, out=tmp_path)
    assert code == 0
    after = {path.name for path in tmp_path.iterdir()}
    assert before - after == {"attractors.csv", "crises.csv", "density_2.png"}
    assert "removed what an earlier run wrote: attractors.csv, crises.csv, density_2.png" in text
    record = json.loads((tmp_path / "about_analyse.json").read_text(encoding="utf-8"))
    assert set(record["files"]) == after - {"about_analyse.json"}
    assert (record["map"], record["span"]) == (tent, ["5/4", "9/4"])
    assert read_graph(tmp_path / "graph.graphml").graph["map"] == tent


@pytest.mark.slow
def test_intervals_of_symbols_are_no_markup(tmp_path: Path) -> None:
    """[b, ...] would be taken for an opening tag."""
    map_ = "Piecewise((a*x + r, x < b), (r, True))"
    code, text = run(map_, "--parameter", "r", "--orders", "1", "--given", "a > 1",
                     out=tmp_path / "[b]")  # fmt: skip
    assert code == 0
    assert "r in [b, 7]" in text
    assert f"wrote {tmp_path / '[b]' / 'points.csv'}, " in text


@pytest.mark.slow
def test_the_table_says_which_attractors_are_missing(tmp_path: Path) -> None:
    """Right of 10 all points go to 10, through which no neighbour comes: that is open."""
    map_ = "Piecewise((a*x, x <= 1/2), (a*(1 - x), x < 10), (10, True))"
    code, text = run(map_, "--parameter", "a", "--density", "7/4", "--orders", "1", out=tmp_path)
    assert code == 0
    assert "1 band: [7/32, 7/8]" in text
    assert "incomplete: open beside the break 10" in text


def test_the_long_run_needs_a_density(tmp_path: Path) -> None:
    tent = "Piecewise((a*x, x <= 1/2), (a*(1 - x), True))"
    span = ("--span", "0", "1")
    code, text = run(tent, "--parameter", "a", *span, "--density", "1/2", out=tmp_path / "new")
    assert code == 1
    assert "Failed: at a = 1/2 no chaotic attractor has a density; what was finished" in text
    assert (tmp_path / "new" / "diagram.png").exists()


SKEW = "Piecewise((a*x + 1, x <= 0), (b*x + 1, True))"


def run_plane(*arguments: str, out: Path) -> tuple[int, str]:
    found = CliRunner().invoke(app, ["plane", SKEW, *arguments, "--out", str(out)])
    return found.exit_code, found.output


@pytest.mark.slow
def test_a_plane_is_drawn_with_its_curves_and_points(tmp_path: Path) -> None:
    spans = ("--across-span", "1/4", "3/4", "--along-span", "-5", "-1/2")
    code, text = run_plane(
        "--across", "a", "--along", "b", *spans, "--orders", "1,2,3",
        "--colours", "bands", "--raster", "4", "3", out=tmp_path,
    )  # fmt: skip
    assert code == 0
    for part in ("a**2*b + 1", "a*b + a + 1", "flip-border", "0.61803398875"):
        assert part in text
    assert (tmp_path / "plane.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    curves = (tmp_path / "plane_curves.csv").read_text().splitlines()
    assert curves[0] == "id,kind,note,words,polynomial,from,to"
    assert "BC1,BC,fold,LLR LRR,a*b + a + 1,," in curves
    points = (tmp_path / "plane_points.csv").read_text().splitlines()
    assert points[1].endswith("-1/2 + sqrt(5)/2,-3/2 - sqrt(5)/2,PD3 BC1")
    saved = load_plane(tmp_path / "plane.json")
    assert [curve.id for curve in saved.curves] == [line.split(",")[0] for line in curves[1:]]
    assert load_raster(tmp_path / "plane_raster.json").periods.shape == (3, 4)


@pytest.mark.nightly
@pytest.mark.parametrize("more", [(), ("--format", "csv", "--format", "png")])
def test_pictures_are_drawn_though_nobody_reads_the_tables(
    more: tuple[str, ...], tmp_path: Path
) -> None:
    given = ["--parameter", "r", "--set", "a=5/4", "--orders", "1", "--out", str(tmp_path), *more]
    command = [sys.executable, "-m", "pwmap", "analyse", P1L, *given]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        running.stdout.close()
        assert b"rror" not in running.stderr.read()
    assert running.returncode == 0
    assert (tmp_path / "diagram.png").exists()
