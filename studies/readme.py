"""The numbers of ``studies/results/README.md`` and other pages, written from the results of studies.

    python -m studies.readme

Blocks between ``<!-- results: NAME -->`` and ``<!-- end -->`` are written from
``studies/results/*.json``; a test fails if a page differs.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from studies.common.record import ROOT, Results
from studies.common.tables import fixed, minus, number, pretty, rows, seconds, shortest
from studies.mechanisms import mechanisms
from studies.run_all import RESULTS, STUDIES
from studies.sensitivities import PAPER_PERIOD
from studies.systems.peers import machines

PAGES = (RESULTS / "README.md", RESULTS / "diagrams.md", ROOT / "docs" / "comparison.md")
BLOCK = re.compile(r"(<!-- results: (\w+) -->\n).*?(<!-- end -->)", flags=re.DOTALL)
All = Mapping[str, Results]
SPAN = "(0.012, 1)"
# Points of P_1 that have a name: eps_N1 under the sum and contact by contact, None if there is none.
NAMED = {
    "A": (0.11197091, 0.04216433),
    "B": (0.29152171, 0.32103615),
    "C": (0.18512695, 0.18512695),
    "end of the branch from A": (0.18815862, 0.06981782),
    "end of the branch from B": (0.04532574, None),
    "I_1 at its top, left": (0.34192345, 0.34192345),
    "I_1 at its top, right": (0.38834959, 0.38834959),
    "I_2 at its end": (0.79516064, 0.79587658),
}
SAME = 1e-6  # in eps_N1: a named point


def main() -> None:
    """Rewrite the blocks of the pages."""
    results = load(RESULTS)
    for page in PAGES:
        page.write_text(filled(page.read_text(encoding="utf-8"), results), encoding="utf-8")


def load(folder: Path) -> dict[str, Results]:
    """Results of all studies by name."""
    return {
        name: json.loads((folder / f"{name}.json").read_text(encoding="utf-8")) for name in STUDIES
    }


def filled(text: str, results: All) -> str:
    """A text with its blocks made anew."""

    def block(found: re.Match[str]) -> str:
        return f"{found[1]}{BLOCKS[found[2]](results)}\n{found[3]}"

    return BLOCK.sub(block, text)


# --- Blocks ---------------------------------------------------------------------------------------


def paper(results: All) -> str:
    """What the paper prints, what the model gives."""
    found = results["paper_numbers"]
    lines = []
    for row in found["rows"]:
        ours = row["ours"]
        shown = str(ours) if isinstance(ours, int) else shortest(ours, row["paper"])
        other = row["separate"]
        separate = "" if other is None else shortest(other, row["paper"])
        verdict = {True: "yes", False: "**no**", None: "–"}[row["agrees"]]
        lines.append(
            [pretty(row["quantity"]), minus(row["paper"]), shown, verdict, separate,
             row["checked_by"], pretty(row["remark"])]
        )  # fmt: skip
    header = ["quantity", "paper", "here", "agrees", "contact by contact", "checked by", "remark"]
    table = rows(header, lines)
    return f"{table}\n\n{found['agree']} of these numbers agree, {found['differ']} differ."


def vertices(results: All) -> str:
    """Figure 8, vertex by vertex."""
    found = results["fig08_vertices"]
    lines = []
    for kind, text in (("double", "with an impact at two contacts"), ("single", "without")):
        for law, name in (("summed", "sum"), ("separate", "contact by contact")):
            row = found["laws"][law][kind]
            lines.append(
                [text, name, str(row["count"]), str(row["within"]),
                 number(row["vertical"]["0.5"]), number(row["to_curve"]["0.5"]),
                 number(row["to_curve"]["0.9"]), str(row["off"])]
            )  # fmt: skip
    header = [
        "returns", "law", "vertices", "within the rounding", "median of abs(P_1 − y) [rad]",
        "distance from the curve, median", "9 of 10 below", "above 1e-3 rad",
    ]  # fmt: skip
    summed, line = found["laws"]["summed"], found["line"]
    steep = sum(summed[kind]["steep"] for kind in ("double", "single"))
    places = ", ".join(f"({fixed(x)}, {fixed(y)})" for x, y in found["off_at"])
    return (
        f"{rows(header, lines)}\n\n"
        f"The line of Figure 8 has {found['vertices']} vertices, on a grid of {found['unit'][0]:.2g} "
        f"by {found['unit'][1]:.2g} rad. {summed['jammed']['count']} more of them belong to a sleeve "
        f"that stays jammed, and {line['count']} to the straight line on the right. That line is no "
        f"motion of the toy: its vertices are within {number(line['from_jammed'])} rad of what a sleeve "
        f"would do that stays jammed where friction cannot hold it. Included are {steep} vertices where "
        f"the map is steeper than 10, {found['beside_a_jump']} beside a jump and "
        f"{found['drawn_twice']} that are drawn twice; the {len(found['off_at'])} that neither law "
        f"explains, {places}, lie on the flanks of a dip. The paper's line crosses the diagonal at "
        f"{fixed(found['fixed_point'])} rad, the toy's cycle is at "
        f"{fixed(results['sensitivities']['phi_s'])}."
    )


def sensitivities(results: All) -> str:
    """How little would explain the period."""
    found = results["sensitivities"]
    loose = found["unsettled"]
    first, second = (fixed(x) for x in loose["minima"])
    ranked = sorted(
        found["sensitivities"].items(), key=lambda item: -abs(item[1]["period"] or 0.0)
    )[:5]
    effects = ", ".join(f"`{name}` {number(row['period'])}" for name, row in ranked)
    return (
        f"The paper's period is {number(100.0 * -found['missing'])} % short of ours. Read off the "
        f"paper's Figure 4, it is the time between two strikes of the beak in a motion that has not "
        f"settled: its minima are {first} and {second} rad. From {first} the toy's next minimum is "
        f"{fixed(loose['after'])}, and its beak strikes {loose['beats']:.6f} s apart: that is "
        f"{100.0 * loose['explains']:.0f} % of the difference, and the rest is not explained. Strikes {PAPER_PERIOD:g} s apart need a "
        f"motion from {fixed(loose['start'])} to {fixed(loose['next'])} rad.\n\n"
        f"If the printed number were the period of the settled motion: one percent more of a parameter "
        f"changes it by so many percent: {effects}. {' '.join(found['result'])}"
    )


def curves(results: All) -> str:
    """How many places of curves are confirmed, and what a curve costs."""
    found = results["two_parameters"]
    every = [curve for plane in found["curves"].values() for curve in plane.values()]
    looked, confirmed = (sum(curve[key] for curve in every) for key in ("looked", "confirmed"))
    off = max(curve["off"] for curve in every if curve["off"] is not None)
    a = found["a"]
    return (
        f"Of these {len(every)} curves every tenth place was located anew by a one-parameter computation: "
        f"{confirmed} of {looked} are there, with the same code, off by at most {number(off)}. "
        f"{a['places']} places of A cost {seconds(a['seconds'])}; to bisect for {a['anew']} of them with "
        f"`shoot` takes {seconds(a['bisected_seconds'])}."
    )


def regions(results: All) -> str:
    """How many regions planes are cut into, and how much of them is wrong."""
    lines = [
        [
            f"`eps_n1`, `{second}`", str(each["curves"]), str(len(each["regions"])),
            str(each["checks"]), str(len(each["open"])),
        ]
        for second, each in results["regions"].items()
        if second != "environment"
    ]  # fmt: skip
    return rows(["plane", "curves", "regions", "random places", "disagree"], lines)


def robustness(results: All) -> str:
    """How far the motion is from its end, all parameters together and each alone."""
    found = results["robustness"]
    first = found["critical"][0]
    ranked = sorted(first["changes"].items(), key=lambda item: -abs(item[1]))[:5]
    changes = ", ".join(f"`{name}` {value:+.2f} %" for name, value in ranked)
    alone: dict[str, dict[int, str]] = {}
    for each in found["limits"]:
        what = {"PD": "flip", "LP": "fold"}.get(each["kind"], each["cause"])
        text = "none" if each["percent"] is None else f"{each['percent']:+.3g} % ({what})"
        alone.setdefault(each["parameter"], {})[each["direction"]] = minus(text)
    nearest = sorted(
        found["limits"],
        key=lambda each: math.inf if each["percent"] is None else abs(each["percent"]),
    )
    names = list(dict.fromkeys(each["parameter"] for each in nearest))[:8]
    table = rows(
        ["parameter alone", "down", "up"], [[f"`{n}`", alone[n][-1], alone[n][1]] for n in names]
    )
    seen = (
        "shooting on both sides confirms it" if first["confirmed"] else "not confirmed by shooting"
    )
    return (
        f"The nearest bifurcation of the paper's toy is {first['percent']:.3f} % away (root of the sum of the "
        f"squares of all relative changes): {minus(changes)} and less of the others; there "
        f"{first['cause']} ({seen}).\n\n{table}"
    )


def precision(results: All) -> str:
    """Which peer is cheapest at an error, relative to the kernel."""
    found = results["work_precision"]
    lines = []
    for task, entries in found["table"].items():
        cells = []
        for entry in entries:
            ratio = entry["ratio"]
            cells.append("none" if ratio is None else f"{number(ratio)} ({entry['peer']})")
        lines.append(
            [task, seconds(entries[0]["kernel_cpu"]), *cells, _proved(found["tasks"][task])]
        )
    bounds = [f"{entry['error_below']:.0e}" for entry in next(iter(found["table"].values()))]
    header = ["task", "kernel", *(f"error < {bound}" for bound in bounds), "proved (ball arithmetic)"]  # fmt: skip
    ahead = (
        "The compiled kernel is ahead of every peer at every error below 1e-3 that was measured."
        if found["kernel_ahead"]
        else "The kernel is not ahead everywhere: ratios below one say where."
    )
    return f"{rows(header, lines)}\n\n{ahead}"


def _proved(entries: Sequence[Mapping[str, Any]]) -> str:
    """What the closest proof costs relative to the kernel, and how close it is."""
    kernel, *others = entries
    done = (row for row in others if row["method"] == "ball arithmetic" and row["lost"] is None)
    best = min(done, key=lambda row: float(row["error"]), default=None)
    if best is None:
        return "none"
    return f"{number(best['cpu'] / kernel['cpu'])} (to {number(best['error'])})"


def siconos(results: All) -> str:
    """The same motion by an established program."""
    found = results["peer_siconos"]["cycle"]["2e-05"]
    unit = results["benchmark"]["timings"]["one return, compiled kernel"]["cpu_median"]
    period = results["sensitivities"]["period"]
    return (
        f"Siconos, at a step of 2e-05 s, gives the cycle a period of {found['period_mean']:.5f} ± "
        f"{found['period_spread']:.5f} s (the kernel: {period:.8f} s) and computes "
        f"{number(found['seconds_per_second'])} s for each simulated second, the kernel "
        f"{seconds(unit / period)}."
    )


def peers(results: All) -> str:
    """One return of the cycle and a simulated second by programs that step, and by the kernel."""
    stepped, moreau = results["peer_siconos"], results["peer_moreau"]["theta, lcp"]
    measured, period = results["benchmark"], results["sensitivities"]["period"]
    lines = []
    for step, found in stepped["cycle"].items():
        error = stepped["return"][step]["error"]
        lines.append(["Siconos", f"{step} s", number(error), seconds(found["seconds_per_second"])])
    for step, error, cpu in zip(moreau["step"], moreau["error"], moreau["cpu_ms"], strict=True):
        if step in (1e-4, 1e-6):
            name = "Moreau's scheme for this toy alone, compiled"
            lines.append([name, f"{step:.0e} s", number(error), seconds(cpu / 1e3 / period)])
    unit = measured["timings"]["one return, compiled kernel"]["cpu_median"]
    lines.append(["woodpecker", "none", number(measured["error_kernel"]), seconds(unit / period)])
    header = ["program", "step", "error of a return [rad]", "time for a simulated second"]
    return rows(header, lines)


def general(results: All) -> str:
    """The branch of the stable motion by a general continuation program."""
    found = results["peer_pydstool"]
    lines = [
        [
            number(run["step"]),
            "1" if run["forward"] else "0",
            str(run["points"]),
            str(run["asked"]),
            " ".join(name or "–" for name in run["route"]),
            ", ".join(" to ".join(pair) for pair in run["leaps"]) or "none",
            fixed(run["last"][0], 6),
        ]
        for run in found["runs"]
    ]
    header = ["largest step", "towards", "points", "images", "where its points lie, in order", "leaps", "last ε_N1"]  # fmt: skip
    ids = sorted({name for run in found["runs"] for name in run["route"] if name})
    return (
        f"{rows(header, lines)}\n\n"
        f"`continuation` finds {found['branches']} branches and {found['points']} special points that are connected "
        f"there. Its fixed points on the branches above live at these ε_N1: {_lives(results, ids)}."
    )


def _lives(results: All, ids: Sequence[str]) -> str:
    """Between which values of ε_N1 branches of the main job lie."""
    ends: dict[str, list[float]] = {name: [] for name in ids}
    for _, _, _, p, *_, left, right in results["main_job"]["points"]:
        for name in f"{left} {right}".split():
            ends.get(name, []).append(p)
    return ", ".join(f"{name} {min(ps):.4f} to {max(ps):.4f}" for name, ps in ends.items())


def orders(results: All) -> str:
    """Expected and fitted orders."""
    lines = [
        [
            f"{row['method']} {row['variant']}".strip(), number(row["expected"]),
            number(row["fitted"], 3), f"{row['errors'][0]:.0e} to {row['errors'][-1]:.0e}",
            row["why"],
        ]
        for row in results["work_precision"]["orders"]
        if row["fitted"] is not None and row["task"] == "cycle"
    ]  # fmt: skip
    return rows(["method", "expected", "fitted", "errors", "because"], lines)


def failures(results: All) -> str:
    """How many scenes each method resolves."""
    found = results["failures"]["summary"]
    kinds = list(dict.fromkeys(kind for counts in found.values() for kind in counts))
    lines = [
        [method, *(str(counts.get(kind, 0) or "") for kind in kinds)]
        for method, counts in found.items()
    ]
    return rows(["scenes", *kinds], lines)


def main_job(results: All) -> str:
    """The special points of the main job, each with what happens there."""
    found = results["main_job"]
    lines = [
        [
            name,
            ", ".join(filter(None, (code, note))),
            minus(f"{p:.10f}"),
            minus(f"{x:.10f}"),
            number(precision, 1),
            "" if cause == note else cause,
            left,
            right,
        ]
        for name, code, note, p, x, precision, cause, left, right in found["points"]
    ]
    header = ["point", "code", "ε_N1", "φ_S [rad]", "located to", "what happens", "left", "right"]
    return (
        f"{rows(header, lines)}\n\n{found['branches']} branches, {len(lines)} special points, and "
        f"{found['changes']} changes of word on the way, at which the map does not jump."
    )


def reductions(results: All) -> str:
    """What each reduction buys."""
    text: str = results["reductions"]["text"]
    return text


def kernel(results: All) -> str:
    """Times of the kernel."""
    found = results["benchmark"]
    times = {name: timing["cpu_median"] for name, timing in found["timings"].items()}
    unit = times["one return, compiled kernel"]
    names = (
        ("one return, compiled kernel", "one return of the cycle, compiled kernel"),
        ("one return, first_return()", "the same through `first_return`"),
        ("one return, plain Python kernel", "the same in plain Python"),
        ("one return, DOP853 rtol 1e-10", "the same by `solve_ivp` (DOP853, rtol 1e-10, events)"),
        ("map of 1000 points, one core", "map of 1000 points, one core"),
        (
            "continuation in eps_N1",
            f"`continuation` over ε_N1 in (0, 1): {found['branches']} branches, "
            f"{found['points']} special points",
        ),
        ("first call, compiling", "first call on a new machine, compiling (then cached)"),
    )
    lines = [
        [text, seconds(times[name]), number(times[name] / unit) if "one return" in name else ""]
        for name, text in names
    ]
    return (
        f"{rows(['', 'CPU time', 'against the kernel'], lines)}\n\n"
        f"The image of the cycle's return is in error by {number(found['error_kernel'])} rad "
        f"(kernel) and {number(found['error_peer'])} rad (DOP853) against 30 digits."
    )


def diagrams(results: All) -> str:
    """What the search for everything found, and what it cost."""
    one = results["fig09_order_one"]
    coarse, fine = sorted(one["tables"], key=lambda table: -table["spacing"])
    return (
        f"{named(one)}\n\n"
        f"P_1 over ε_N1 in {SPAN}, φ_S in (−2.5, −0.24): {one['branches']} branches and "
        f"{one['points']} special points from {one['slices']} slices, in "
        f"{number(one['seconds']['wall'])} s of wall time and {number(one['seconds']['cpu'])} s of CPU. "
        f"P_1 was evaluated {number(one['evaluations'] / 1e6)} million times; a table with a column "
        f"at every parameter of the diagram would take {number(coarse['ratio'])} times as many "
        f"at a spacing of {coarse['spacing']:g} rad, {number(fine['ratio'])} times at {fine['spacing']:g}. "
        f"Of {one['orbits']} orbits that settle, {one['chaotic']} are chaotic; "
        f"{len(one['unexplained'])} are explained neither by a stable branch nor by chaos."
    )


def named(one: Results) -> str:
    """The named points of P_1 under both laws."""
    both = one["collisions"], one["separate"]["collisions"]
    lines = []
    for name, values in NAMED.items():
        cells = []
        for found, value in zip(both, values, strict=True):
            at = [p for p in found if value is not None and abs(p[2] - value) < SAME]
            kind, note, p, _ = at[0] if at else ("–", "", math.nan, math.nan)
            cells += [f"{kind} {note}".strip(), f"{p:.9f}" if at else ""]
        x = next(p[3] for p in both[0] if abs(p[2] - float(values[0] or 0.0)) < SAME)
        lines.append([name, *cells, fixed(x, 7)])
    header = ["point of P_1", "sum (inferred)", "ε_N1", "contact by contact", "ε_N1", "φ_S, sum [rad]"]  # fmt: skip
    return rows(header, lines)


def completeness(results: All) -> str:
    """What plain tabulation says of the diagrams of the paper's toy, and of random ones."""
    found = results["completeness"]
    paper, total, toys = found["paper"], found["total"], found["toys"]
    sums = {name: len(paper[name]) for name in ("missing", "double", "unconfirmed", "open")}
    sums["unfinished"] = int(bool(paper["left"]))
    header = ["", "tables", "cycles", "jumps", "drawn", "too close for a table", "missing", "twice", "not confirmed", "given up", "searches unfinished"]  # fmt: skip
    lines = [
        [name, str(tables), *(str(row[key]) for key in ("cycles", "jumps")),
         str(row["drawn_cycles"] + row["drawn_jumps"]),
         *(str(row[key]) for key in ("closer", "missing", "double", "unconfirmed", "open", "unfinished"))]
        for name, tables, row in (
            ("P_1 and P_2 of the paper's toy", len(paper["tables"]), {**paper, **sums}),
            (f"P_1 of {len(toys)} random toys", sum(toy["places"] for toy in toys), total),
        )
    ]  # fmt: skip
    return rows(header, lines)


def systems(results: All) -> str:
    """Systems of contacts by the general method, against what is known of them in closed form."""
    toy, oscillator, friction, table, block, wheel, belt = (
        results[f"system_{name}"]
        for name in (
            "toy",
            "oscillator",
            "den_hartog",
            "table",
            "rocking_block",
            "rimless_wheel",
            "fold_flip",
        )
    )
    same = f"{toy['same_words']} of {toy['returns']} words; images, over 1 + slope"
    oscillators = f"{oscillator['oscillators']} impact oscillators"
    lines = [
        ["the toy, against its own kernel", same, number(toy["largest_difference"])],
        [oscillators, "fold of the motion with one impact", number(oscillator["fold"])],
        [oscillators, "its flip", number(oscillator["flip"])],
        ["impact oscillator", "grazing, by continuation", number(abs(oscillator["grazing"]))],
        [f"Den Hartog's oscillator, {friction['frequencies']} frequencies", "amplitude without stops",
         number(friction["largest_difference"])],
        ["Den Hartog's oscillator", "amplitude with two stops", number(friction["with_stops"])],
        ["Den Hartog's oscillator", "where stops begin, a change of word on its branch", number(friction["border"])],
        ["ball on a vibrating table", "motion of one bounce closes", number(table["closes"])],
        ["ball on a vibrating table", "its fold, by continuation", number(table["fold"])],
        ["ball on a vibrating table", "its flip, by continuation", number(table["flip"])],
        ["completely inelastic ball", "flip at √(4 + π²), by continuation",
         number(table["inelastic"])],
        ["Hogan's rocking block", "fold of the symmetric motion", number(block["fold"])],
        ["Hogan's rocking block", "its pitchfork", number(block["pitchfork"])],
        ["rimless wheel", "speed of the walk", number(wheel["speed"])],
        ["rimless wheel", "its multiplier", number(wheel["multiplier"])],
        ["pushed oscillator on a belt, against DOP853", "fold-flip, by continuation", number(belt["border"])],
        ["pushed oscillator on a belt, against DOP853", "multipliers beside it", number(belt["multipliers"])],
    ]  # fmt: skip
    ratio = f"A return of the toy takes {number(toy['ratio'])} times as long as by its own kernel."
    table_ = rows(["system", "what", "off by"], lines)
    return f"{table_}\n\n{ratio}\n\n{_random(results['system_random'])}"


def _random(found: Mapping[str, Any]) -> str:
    """What random systems keep, and how often both backends say the same."""
    ended = found["statuses"]
    done = ended.get("TIME_REACHED", 0) + ended.get("AT_REST", 0)
    return (
        f"Of {found['systems']} random systems of 2 to 4 coordinates and 1 to 3 contacts {done} are followed to the end or to "
        f"rest, and all others stop with a sentence; motions that gain energy in an impact, have a nan or overflow: "
        f"{found['faults']}. Both backends say the same word in {found['same_words']} of {found['compared']}."
    )


def symbolic(results: All) -> str:
    """Times of symbolic composition."""
    found = results["symbolic"]
    times = {name: timing["cpu_median"] for name, timing in found["timings"].items()}
    lines = [
        ["P_1 to P_6 symbolic in a and r: pieces, ends and words", seconds(times["P1..P6 in a and r"])],
        ["the same from the formula on", seconds(times["pwmap, order 6"])],
        [
            "the same by `sympy.Piecewise`, substituted and folded",
            f"{seconds(times['sympy, order 6'])} ({number(found['ratio_order_6'])} times)",
        ],
        ["P_1 to P_12 at a = 5/4, r = 1", seconds(times["P1..P12 at a = 5/4, r = 1"])],
        [
            f"exact diagram of orders 1 to 5, a = 5/4, r in (−1, 12): {found['branches']} branches, "
            f"{found['points']} points",
            seconds(times["diagram, orders 1..5"]),
        ],
    ]  # fmt: skip
    return rows(["", "CPU time"], lines)


def ground(results: All) -> str:
    """Exact jobs with sympy's own rationals and with those of python-flint."""
    found = results["ground_types"]
    times = {name: timing["cpu_median"] for name, timing in found["timings"].items()}
    lines = [
        [name, seconds(times[f"{name}, python"]), seconds(times[f"{name}, flint"]), f"{gain:.2f}"]
        for name, gain in found["ratios"].items()
    ]
    return rows(["", "sympy's rationals", "python-flint", "ratio"], lines)


def machine(results: All) -> str:
    """What the results of this part were measured on: times of two machines do not compare."""
    parts = {"methods and orders": "work_precision", "the kernel": "benchmark"}
    where = "; ".join(
        f"{part} on {_processor(results[study]['environment'])}" for part, study in parts.items()
    )
    return (
        f"All times are CPU times: {where}. Machines are shared and differ by a factor of two, so "
        "ratios are of one table, measured in alternating rounds."
    )


def _processor(found: Mapping[str, Any]) -> str:
    versions = ", ".join(f"{name} {found[name]}" for name in ("python", "numpy", "scipy", "numba"))
    return f"{found['processor']}, {found['cores']} cores, {versions}"


def long_run(results: All) -> str:
    """Entropy by bounds and by Ulam's method, and random maps."""
    found = results["long_run"]
    lines = []
    for name, graphs in found["entropy"].items():
        last, ulam = graphs[-1], found["ulam"][name][-1]
        lines.append(
            [name.replace("-", "−"), number(last["width"]), seconds(last["cpu"]), number(ulam["entropy"]),
             number(ulam["density"]), seconds(ulam["cpu"])]
        )  # fmt: skip
    order, bins = last["order"], ulam["bins"]
    header = ["map", f"bounds of order {order}: width", "CPU time", f"Ulam, {bins} bins: error", "of the density", "CPU time"]  # fmt: skip
    kinds = "; ".join(
        f"{kind}: {seconds(times['everything']['median'])} ({seconds(times['everything']['worst'])})"
        for kind, times in found["random"].items()
    )
    return (
        f"{rows(header, lines)}\n\n"
        f"Attractors, basins, kneading sequences, densities, exponents and entropy of a random map at one "
        f"place take, in the median (and at most): {kinds}."
    )


def proofs(results: All) -> str:
    """What is proved, how wide, and what it costs; and random returns."""
    found = results["proofs"]
    claims = {"period": "period [s]", "p": "ε_N1", "multiplier": "multiplier"}
    lines = [
        [row["name"].replace("_", " "), str(row["boxes"]), f"{claims[row['claim']]} to {number(row['width'])}",
         seconds(row["seconds"]), seconds(row["checking"])]
        for row in found["statements"]
    ]  # fmt: skip
    header = ["statement", "boxes", "enclosed", "proved in", "checked in"]
    back = found["returns"]
    accumulate = sum("C" in row["word"] for row in back["undecided"])
    return (
        f"{rows(header, lines)}\n\n"
        f"Of {back['count']} returns from random starts under both laws {back['held']} enclosures hold thirty digits of "
        f"another program, {len(back['undecided'])} are undecided ({accumulate} of these have impacts that accumulate), "
        f"and none misses. An enclosed return takes {seconds(back['seconds'])} and is {number(back['median_width'])} wide; "
        f"in doubles it takes {seconds(back['seconds_in_doubles'])} and is off by {number(back['off_in_doubles'])}; thirty "
        f"digits without proof take {seconds(back['seconds_of_reference'])}."
    )


BLOCKS: dict[str, Callable[[All], str]] = {
    block.__name__: block
    for block in (
        main_job, paper, vertices, sensitivities, curves, regions, robustness, precision, siconos, peers, general, orders, failures, reductions, kernel, diagrams, completeness, systems, machines, symbolic,
        ground, long_run, proofs, machine, mechanisms,
    )
}  # fmt: skip


def unexplained(text: str, allowed: Sequence[str]) -> list[str]:
    """Decimal numbers of a page that stand neither in a block, nor in code, nor on a list."""
    bare = re.sub(r"```.*?```", "", BLOCK.sub("", text), flags=re.DOTALL)
    bare = re.sub(r"^    .*$", "", re.sub(r"`[^`]*`", "", bare), flags=re.MULTILINE)
    bare = re.sub(r"\]\([^)]*\)", "]", bare)
    found = re.findall(r"[−-]?\d+\.\d+(?:e-?\d+)?|\d+e-?\d+|\d+(?= ?(?:%|s\b|ms|µs|MB))", bare)
    return [text for text in found if text not in allowed]


if __name__ == "__main__":
    main()
