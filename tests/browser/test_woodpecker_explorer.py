"""The explorer of the toy in a browser: pixels and data of every view, all that can be asked."""

import json
import signal
from http.client import HTTPConnection
from pathlib import Path
from typing import Any
from urllib.error import HTTPError
from urllib.request import urlopen

import numpy as np
import pytest
from explored import Seen, Served, served
from processes import is_running, wait_until

from woodpecker import Toy, continuation, first_return, shoot, simulate

pytestmark = [pytest.mark.browser, pytest.mark.slow]
PAGE = "toy"
OTHER_SIZES = (1024, 768), (768, 1024), (1920, 1080)
STABLE = -0.5294719671  # rad, of the paper's data


# --- Each view ------------------------------------------------------------------------------------


def test_the_diagram_is_that_of_python(tab: Seen) -> None:
    tab.complete()
    diagram = continuation(Toy(), shoot(Toy(), -0.53), "eps_n1", (0.0, 1.0))
    points = tab.table("points")
    found = sorted(zip(points["x"], points["y"], strict=True))
    known = sorted((point.parameter, point.x) for point in diagram.points)
    assert np.abs(np.array(found) - np.array(known)).max() < 1e-9
    labels = dict(zip(points["label"], points["x"], strict=True))
    assert abs(labels["A"] - 0.11197091) < 1e-8
    assert abs(labels["B"] - 0.29152171) < 1e-8
    assert abs(labels["C"] - 0.18512695) < 1e-8
    assert any("strike at once" in cause for cause in points["cause"])
    samples = tab.table("samples")
    assert "S2 D2 I3 D3 I1 I3 D3 I2 D2 I2 J2" in samples["word"]
    edges = tab.table("edges")
    assert sorted(edges["branch"]) == sorted(branch.id for branch in diagram.branches)


def test_the_motion_is_that_of_python(tab: Seen) -> None:
    orbit = shoot(Toy(), -0.53)
    motion = simulate(Toy(), orbit.phi_s, orbit.period, samples=320)
    data = tab.table("motion")
    assert np.abs(np.array(data["t"]) - 1e3 * motion.t).max() < 1e-9
    assert np.abs(np.array(data["phi_s"]) - motion.q[:, 2]).max() < 1e-12
    events = tab.table("events")
    assert " ".join(events["symbol"]) == orbit.word
    assert tab.page.locator("#number-multiplier").inner_text() == f"{orbit.multiplier:.5f}"
    beak = events["impulses"][events["symbol"].index("I1")]
    assert beak.startswith("contact 1: Λ_N")
    way = tab.table("way")
    assert len(way["x"]) > 300


def test_the_toy_is_drawn_by_the_equations_of_the_picture(tab: Seen) -> None:
    """The script's geometry is that of woodpecker.plot.drawing, to rounding."""
    from woodpecker.plot.drawing import bird, points

    toy, q = Toy(), (-0.003, 0.07, -0.4)
    placed = points(toy, q)
    for k, exact in ((1, placed.beak), (2, placed.lower), (3, placed.upper)):
        drawn = tab(f"toy.contact(explorer.answer.shape, {list(q)}, {k})")
        assert np.abs(np.array(drawn) - exact).max() < 1e-15
    drawn = tab(f"toy.bird(explorer.answer.shape, {list(q)}, [1.3, -0.2])")
    assert np.abs(np.array(drawn) - bird(toy, q, (1.3, -0.2))).max() < 1e-15
    coil = np.array(tab(f"toy.spring(explorer.answer.shape, {list(q)})"))
    assert np.abs(coil[[0, -1]] - placed.spring[[0, -1]]).max() < 1e-5  # its ends


@pytest.mark.nightly
def test_contacts_are_lit_as_they_close(tab: Seen) -> None:
    orbit = shoot(Toy(), -0.53)
    motion = simulate(Toy(), orbit.phi_s, orbit.period)
    beak = next(event.time for event in motion.events if event.symbol == "I1")
    before, after = ((beak + step) / motion.t_end for step in (-2e-4, 1e-4))
    tab(f"clock.lit = {{1: 0, 2: 0, 3: 0}}; clock.at = {after}")
    tab(f"clock.show(16, clock.state({before}).low)")
    assert tab("clock.lit[1]") == 1
    tab(f"clock.at = {(beak + 3e-4) / motion.t_end}; clock.show(0, clock.row)")
    tab("clock.show(80, clock.row)")  # nothing closes meanwhile
    assert 0 < tab("clock.lit[1]") < 1  # the light goes out in a sixth of a second
    tab("clock.at = 0; clock.lit = {1: 0, 2: 0, 3: 0}; clock.show(16, 0)")
    assert tab("clock.lit[2]") == 1  # the sleeve is jammed on its lower edge


# --- What can be asked ----------------------------------------------------------------------------


def test_a_slider_moves_everything(tab: Seen) -> None:
    before = tab.table("events")["time"]
    box = tab.page.locator("#slider-eps_n1").bounding_box()
    assert box is not None
    middle = box["y"] + box["height"] / 2
    tab.page.mouse.move(box["x"] + box["width"] / 2, middle)
    tab.page.mouse.down()
    for k in range(12):
        tab.page.mouse.move(box["x"] + box["width"] * (0.5 - 0.01 * k), middle)
    tab.rest()
    value, start = tab.answer["values"]["eps_n1"], tab.answer["start"]
    motion = simulate(Toy(eps_n1=value), start, tab.answer["numbers"]["period"], samples=320)
    drawn = tab("Array.from(sketch.data(explorer.doc.get_model_by_name('motion')).phi_s)")
    assert np.abs(np.array(drawn) - motion.q[:, 2]).max() < 1e-12  # of one letter, all numbers
    painted = tab(
        """[...document.querySelectorAll(".sketch")].map((c) =>
           c.pen.getImageData(0, 0, c.width, c.height).data.filter((v) => v > 0).length)"""
    )
    assert len(painted) == 6  # map, diagram, both histories, portrait, word
    assert min(painted) > 100
    tab.page.mouse.up()
    tab.rest()
    value = tab.answer["values"]["eps_n1"]
    assert 0.3 < value < 0.45
    orbit = shoot(Toy(eps_n1=value), -0.56)
    assert abs(tab.answer["start"] - orbit.phi_s) < 1e-9  # both have converged
    assert tab.table("events")["time"] != before
    assert tab("sketch.hidden.length") == 0  # everything is Bokeh's again
    tab.wait("[...document.querySelectorAll('.sketch')].every((each) => each.hidden)")
    assert float(tab.page.locator("#field-eps_n1").input_value()) == pytest.approx(value)
    tab.page.click("#undo")
    tab.wait("explorer.answer.values.eps_n1 === 0.5")  # where the slider was taken


def test_a_click_on_a_branch_brings_everything_there(tab: Seen) -> None:
    tab.complete()
    diagram = continuation(Toy(), shoot(Toy(), -0.53), "eps_n1", (0.0, 1.0))
    unstable = next(
        branch for branch in diagram.branches
        if not branch.stable.any() and str(branch.kind) == "fixed-point" and len(branch) > 10
        and np.ptp(branch.parameter) > 0.05
    )  # fmt: skip
    k = len(unstable) // 2
    p, x = float(unstable.parameter[k]), float(unstable.x[k])
    tab.click("diagram", (p, x))
    answer = tab.answer
    assert answer["branch"] == unstable.id
    assert answer["periodic"] is True
    toy = Toy(eps_n1=answer["values"]["eps_n1"])
    assert abs(first_return(toy, answer["start"]).phi_s - answer["start"]) < 1e-9
    assert abs(answer["numbers"]["multiplier"]) > 1.0
    assert tab.page.locator("#branch").input_value() == unstable.id
    jump = next(branch for branch in diagram.branches if str(branch.kind) == "jump")
    answer = tab.ask(do="branch", value=jump.id)
    assert answer["periodic"] is False
    assert "jump crossing" in answer["message"]


def test_a_click_on_the_map_starts_a_cobweb(tab: Seen) -> None:
    tab.click("map", (-1.7, -2.0))
    start = tab.answer["start"]
    assert abs(start + 1.7) < 0.02  # a pixel is 0.008 rad
    web = np.array(tab.table("web")["x"], dtype=float)
    orbit = [start]
    for _ in range(5):
        orbit.append(first_return(Toy(), orbit[-1]).phi_s)
    assert np.abs(web[[0, 2, 4, 6, 8]] - orbit[:5]).max() < 1e-12
    assert tab.answer["periodic"] is False
    tab.click("map", (STABLE, STABLE))
    assert tab.answer["periodic"] is True


@pytest.mark.nightly
def test_clicks_in_quick_succession_are_all_heard(tab: Seen) -> None:
    """Within 0.3 s of another, a click is heard as well."""
    tab.click("map", (-1.7, -2.0), (STABLE, STABLE), (-1.2, -2.0))
    assert abs(tab.answer["start"] + 1.2) < 0.02
    tab.page.wait_for_timeout(400)
    tab.click("map", (-1.7, -2.0), (STABLE, STABLE))
    assert tab.answer["periodic"] is True


@pytest.mark.nightly
def test_orders_laws_and_portraits(tab: Seen) -> None:
    assert tab.ask(do="order", value="2")["order"] == 2
    assert tab("explorer.doc.get_model_by_name('map').left[0].axis_label").count("k+2") == 1
    answer = tab.ask(do="law", value="separate")
    assert "separate" in answer["query"]
    tab.ask(do="portrait", value="fall")
    label = tab("explorer.doc.get_model_by_name('portrait').left[0].axis_label")
    assert "dot y" in label
    for wish in ({"do": "law", "value": "wrong"}, {"do": "order", "value": "9"}, {"do": "nothing"},
                 {"do": "over", "value": "no_such"}, {"do": "portrait", "value": 3}):  # fmt: skip
        assert tab.ask(**wish)["message"] != ""
    tab.ask(do="reset")
    assert tab.answer["query"].startswith("phi_s=")


def test_a_diagram_may_be_stopped_and_begun_again(tab: Seen) -> None:
    tab.complete()
    tab.ask(do="over", value="mu_2")
    tab.wait("explorer.answer.running")
    tab.ask(do="stop")
    assert tab.answer["running"] is False
    tab.ask(do="search")
    tab.wait("explorer.answer.running")
    tab.wait("explorer.answer.branches.length > 0")  # partial branches
    tab.ask(do="stop")


@pytest.mark.nightly
def test_an_enlarged_view_is_drawn_anew(tab: Seen) -> None:
    """Also where nothing moves."""
    for view, part in (("toy", "#toy-canvas"), ("motion", "#plot-angles"), ("map", "#plot-map")):
        tab.ask(do="focus", value=view)
        tab.page.wait_for_timeout(400)
        assert tab.page.locator(part).bounding_box()["width"] > 800
        assert tab.colours(part) > 20, view


@pytest.mark.nightly
def test_orbits_lie_under_the_branches(tab: Seen) -> None:
    tab.complete()
    tab.ask(do="orbits", value=True)
    orbits = "explorer.doc.get_model_by_name('orbits').data.x"
    tab.wait(f"{orbits}.length > 2000", 90)
    data = tab.table("orbits")
    p, x = np.array(data["x"]), np.array(data["y"])
    near = (p > 0.45) & (p < 0.55)
    assert near.any()
    on_branch = np.abs(x[near] + 0.53) < 0.01  # the stable motion, beside another attractor
    assert 0.3 < on_branch.mean() < 1.0
    tab.ask(do="search")
    tab.ask(do="orbits", value=False)  # while more are looked for
    tab.wait(f"{orbits}.length === 0")
    tab.page.wait_for_timeout(1500)
    assert tab(f"{orbits}.length") == 0


# --- Links, exports, the tour ---------------------------------------------------------------------


def test_a_link_holds_the_state(tab: Seen, chromium: Any, server: Served) -> None:
    tab.ask(do="set", values={"eps_n1": 0.3, "mu_1": 0.25})
    tab.ask(do="law", value="separate")
    tab.ask(do="start", value="-0.7")
    query = tab.page.url.partition("?")[2]
    other = Seen(chromium, server.address, query)
    assert other.answer["values"] == tab.answer["values"]
    assert other.answer["start"] == tab.answer["start"] == -0.7
    assert other.answer["law"] == "separate"
    other.close()


def test_files_are_what_the_lines_of_python_make(tab: Seen, server: Served) -> None:
    tab.ask(do="set", values={"eps_n1": 0.45})
    query = tab.answer["query"]

    def get(name: str) -> tuple[str, bytes]:
        with urlopen(f"{server.address}export/{name}?{query}", timeout=90) as response:
            return response.headers["Content-Type"], response.read()

    kind, picture = get("map.png")
    assert kind == "image/png"
    assert picture.startswith(b"\x89PNG")
    assert get("portrait.svg")[1].lstrip().startswith(b"<?xml")
    rows = get("motion.csv")[1].decode().splitlines()
    space: dict[str, Any] = {}
    exec(get("lines.py")[1].decode(), space)
    last = [float(value) for value in rows[-1].split(",")]
    assert np.abs(last[1:4] - space["motion"].q[-1]).max() < 1e-12
    assert abs(last[0] - space["motion"].t_end) < 1e-12  # both have converged
    saved = json.loads(get("diagram.json")[1])
    assert saved
    branches = get("branches.csv")[1].decode().splitlines()
    assert len(branches) == 1 + sum(len(branch) for branch in space["diagram"].branches)
    state = json.loads(get("state.json")[1])
    assert state["toy"]["eps_n1"] == 0.45


@pytest.mark.parametrize("path", ["export/map.exe?", "export/map.png?eps_n1=2", "export/x.png?"])
def test_what_cannot_be_exported_is_refused_with_a_sentence(server: Served, path: str) -> None:
    with pytest.raises(HTTPError) as caught:
        urlopen(server.address + path, timeout=60)
    assert caught.value.code == 400
    assert caught.value.read().decode()


@pytest.mark.nightly
def test_the_tour_from_end_to_end(tab: Seen) -> None:
    tab.complete()
    tab.page.click("#tour-begin")
    for step in range(1, 11):
        tab.rest()
        assert tab.answer["tour"]["step"] == step
        assert len(tab.page.locator("#tour p").inner_text()) > 60
        assert tab.page.locator(".lit").count() >= 1
        assert tab.answer["message"] == "", step
        tab.complete()
        tab.picture(f"tour_{step:02d}")
        tab.page.click("#tour-next")
    tab.rest()
    assert tab.answer["tour"]["step"] == 1  # round again
    tab.page.click("#tour-end")
    tab.rest()
    assert tab.page.locator("#tour").is_hidden()


# --- Keyboard, sizes, safety, connection ----------------------------------------------------------


def test_everything_is_reached_by_the_keyboard(tab: Seen) -> None:
    """Sliders move by arrows, and whatever a mouse can click has its place in the order of tabs."""
    tab.page.focus("#slider-eps_n1")
    tab.page.keyboard.press("ArrowRight")
    tab.rest()
    assert tab.answer["values"]["eps_n1"] == pytest.approx(0.501)
    reached = tab(
        """[...document.querySelectorAll("button, select, input, summary, a[href]")]
           .filter((each) => each.offsetParent && !each.disabled && each.tabIndex < 0).length"""
    )
    assert reached == 0
    named = tab(
        """[...document.querySelectorAll("button, select, input, canvas")].filter((each) =>
           !(each.textContent.trim() || each.title || each.ariaLabel || each.labels?.length))
           .length"""
    )
    assert named == 0
    tab.complete()
    tab.page.select_option("#branch", "F1")  # branches are a list, too
    tab.rest()
    assert tab.answer["branch"] == "F1"


@pytest.mark.parametrize(
    "size",
    [(1280, 720), *(pytest.param(each, marks=pytest.mark.nightly) for each in OTHER_SIZES)],
)
def test_nothing_overlaps_at_any_size(server: Served, chromium: Any, size: tuple[int, int]) -> None:
    seen = Seen(chromium, server.address, size=size)
    seen.complete()
    seen.picture(f"size_{size[0]}x{size[1]}")
    boxes = seen(
        """[...document.querySelectorAll(".view")].map((v) => v.getBoundingClientRect())
           .map((r) => [r.left, r.top, r.right, r.bottom])"""
    )
    for i, a in enumerate(boxes):
        assert a[2] - a[0] > 100
        assert a[3] - a[1] > 60
        for b in boxes[:i]:
            assert a[0] >= b[2] or b[0] >= a[2] or a[1] >= b[3] or b[1] >= a[3]
    assert seen("document.documentElement.scrollWidth <= innerWidth")
    seen.close()


def test_a_hostile_wish_is_refused(tab: Seen) -> None:
    for text in ('"not json', '{"n": 1}', '{"do": "__class__", "n": 5}', "[1]", "x" * 30_000):
        tab(f"explorer.doc.get_model_by_name('wish').text = {json.dumps(text)}")
        tab.page.wait_for_timeout(150)
    assert tab.ask(do="set", values={"eps_n1": 0.52})["values"]["eps_n1"] == 0.52


def test_other_origins_and_names_are_refused(server: Served) -> None:
    port = server.address.rstrip("/").rpartition(":")[2]

    def status(path: str, **headers: str) -> int:
        link = HTTPConnection("127.0.0.1", int(port), timeout=10)
        try:
            link.request("GET", path, headers={k.replace("_", "-"): v for k, v in headers.items()})
            return link.getresponse().status
        finally:
            link.close()

    assert status("/export/state.json", Host=f"localhost:{port}") == 200
    assert status("/export/state.json", Host=f"evil.example:{port}") == 403
    upgrade = {
        "Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13",
        "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==",
    }  # fmt: skip
    assert status("/ws", Origin="http://evil.example", **upgrade) == 403
    assert status("/ws", Origin=f"http://127.0.0.1:{port}", **upgrade) != 403


@pytest.mark.nightly
def test_a_lost_connection_comes_back(chromium: Any) -> None:
    """The server is gone and comes again: the page loads itself anew, with the same state."""
    first = Served("woodpecker", "explore", "--stay", "--port", "5311")
    seen = Seen(chromium, first.address)
    seen.ask(do="set", values={"eps_n1": 0.37})
    first.end(signal.SIGKILL)
    seen.wait("!document.querySelector('#connection').hidden")
    with served("woodpecker", "explore", "--stay", "--port", "5311"):
        seen.wait(
            "window.explorer?.answer.values && document.querySelector('#connection').hidden"
            " && !explorer.waiting", 120,
        )  # fmt: skip
        assert seen.answer["values"]["eps_n1"] == 0.37
        assert "eps_n1=0.37" in seen.page.url
    seen.page.close()


@pytest.mark.nightly
def test_it_ends_with_its_last_page_and_with_ctrl_c(chromium: Any) -> None:
    last = Served("woodpecker", "explore")
    seen = Seen(chromium, last.address)
    seen.close()
    last.process.wait(40.0)  # by itself
    last.end()
    assert last.process.returncode == 0
    stopped = Served("woodpecker", "explore")
    seen = Seen(chromium, stopped.address, "every=1")
    seen.wait("explorer.answer.running")
    children = _children(stopped.process.pid)
    assert children
    stopped.end(signal.SIGINT)
    wait_until(lambda: not any(is_running(child) for child in children), 10.0)
    seen.page.close()


def _children(pid: int) -> list[int]:
    found = []
    for each in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = each.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if int(fields[1]) == pid:
            child = int(each.parent.name)
            found += [child, *_children(child)]
    return found
