"""No more work than needed: what each reduction of the problem saves, on the same tasks.

    python -m studies.reductions.reductions [--fast] [--out DIR]

(a) Closed form: a smooth phase is one oscillator, known at all times; against numerical
    integration of all six states, in Python with its events (:mod:`studies.peers.ode`), and
    compiled.
(b) Small contact problems: try the few index combinations of one or two contacts; against Lemke's
    algorithm for the general linear complementarity problem, at the impacts of the map.
(c) One coordinate: Newton's method for the fixed point of the map; against Newton's method for all
    five states on the section. Both must find the same multiplier.
(d) Isolated roots: the first root of every guard from its closed form; against samples of all
    guards, N in each period of the free oscillation, for a change of sign.

Impacts at two contacts expand under the toy's own law, friction bounded by the sum of both normal
impulses, in both solvers of (b).

Each pair does the same work in the same language and alternates in rounds; ratios are those of the
medians of CPU time.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from studies.common.places import WINDOW
from studies.common.record import Results, command
from studies.common.style import keep
from studies.peers.kernel import PlainPython
from studies.reductions.closed_form import closed_form
from studies.reductions.contact_problems import contacts
from studies.reductions.draw import bars, draw, paragraph
from studies.reductions.events import GRAZED, events, short
from studies.reductions.motions import beside_edges, recorded, thinned
from studies.reductions.plan import FAST, Plan
from studies.reductions.shooting import shooting
from woodpecker import Toy
from woodpecker.base.compiled import COMPILED


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Measure all four reductions and say in words what came out.

    Parameters
    ----------
    fast
        Take few rounds, starts and densities.
    out
        Folder for ``reductions.png``.

    Returns
    -------
    dict
        ``closed_form``, ``contacts``, ``shooting``, ``events``: seconds, ratios, and how far both
        ways agree; ``ratios``: one number for each bar of the picture; ``text``: a paragraph.
    """
    plan = FAST if fast else Plan()
    starts = np.linspace(*WINDOW, plan.starts)
    phases, impacts = recorded(Toy(), starts)
    hard, _ = recorded(GRAZED, beside_edges(GRAZED, starts[:: plan.starts // plan.edges]))
    with PlainPython() as other:
        found: Results = {
            "compiled": COMPILED,
            "closed_form": closed_form(other, plan),
            "contacts": contacts(thinned(impacts, plan.impacts), other, plan),
            "shooting": shooting(plan),
            "events": events(short(phases), short(hard), plan),
        }
    found["ratios"] = bars(found)
    found["text"] = paragraph(found)
    if out is not None:
        keep(draw(found), out / "reductions.png")
    return found


if __name__ == "__main__":
    command(main, "reductions")
