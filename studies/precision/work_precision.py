"""What does a digit cost? Error against CPU time for the kernel and for all other methods.

    python -m studies.precision.work_precision [--fast] [--out DIR]

Five tasks: three scenes of :mod:`studies.peers.cases`, the map at 1000 points, and the fixed point
with its multiplier. Each method runs over values of its own knob: rtol of ``solve_ivp``, the step
of a time-stepping scheme, the digits of mpmath, the bits of ball arithmetic. The kernel has none.
Errors are distances from 30-digit references; the error of ball arithmetic is its own bound, half
the width of the enclosure. Friction is Coulomb's contact by contact
(``expansion_friction="separate"``): Moreau's scheme and Siconos know no other, and ``solve_ivp``,
with the project's contact problems, follows it too. Methods take turns in rounds, and every time is
that of a call as a user makes it.

- A method that would take minutes for the map runs on twelve of its points; its time is scaled to
  the thousand, and marked ``scaled``.
- A word that differs from the reference's means that events were missed or invented: such points
  are recorded (``word_right``) and drawn hollow, however small their error.
- A return that a method cannot finish is recorded with the reason (``lost``).
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from studies.common.record import Results, command
from studies.common.style import keep
from studies.peers.cases import CYCLE, SCENES
from studies.peers.kernel import PlainPython
from studies.peers.siconos_peer import available
from studies.precision.comparing import ahead, compared, orders
from studies.precision.draw import draw
from studies.precision.measuring import affordable, measured, name
from studies.precision.methods import FAST, Plan, peers, warm
from studies.precision.tasks import (
    FIXED,
    MAP,
    fixed_entries,
    map_entries,
    scene_entries,
    siconos_entries,
)
from woodpecker.base.compiled import COMPILED

SICONOS_ELSEWHERE = "Siconos: only on the scenes, for it starts a process for every return"


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Measure every method on every task, fit orders, draw.

    Parameters
    ----------
    fast
        Take few settings and one round, and the map at a few points.
    out
        Folder for ``work_precision.png``.

    Returns
    -------
    dict
        ``kernel_ahead``: whether, on every task, no peer that gets below 1e-3 is as quick as the
        compiled kernel, and the kernel reaches every target. ``table``: per task and target error
        the cheapest peer, and its time over the kernel's. ``orders``: convergence orders, expected
        and fitted. ``missed``: settings with a wrong word, per task. ``tasks``: all points.
        ``left_out``: what was not measured, and why.
    """
    plan = FAST if fast else Plan()
    settings = list(peers(plan))
    warm(settings)
    with PlainPython() as other, ThreadPoolExecutor(1) as one_core:
        tasks = {
            scene.name: measured(
                [*scene_entries(scene, settings, other), *siconos_entries(scene, plan)],
                plan.rounds,
            )
            for scene in SCENES
        }
        quick, slow = affordable(settings, tasks[CYCLE.name], plan.patience)
        tasks[MAP] = measured(
            map_entries(quick, other, one_core, plan.whole_map), min(plan.rounds, 2)
        )
        tasks[FIXED] = measured(fixed_entries(quick, other), min(plan.rounds, 3))
    table = {task: compared(rows) for task, rows in tasks.items()}
    if out is not None:
        keep(draw(tasks), out / "work_precision.png")
    return {
        "kernel_ahead": all(map(ahead, tasks.values())),
        "compiled": COMPILED,
        "table": table,
        "orders": orders(tasks, plan),
        "missed": {task: [name(row) for row in rows if row["word_right"] is False]
                   for task, rows in tasks.items()},
        "tasks": tasks,
        "left_out": [*slow, available() or SICONOS_ELSEWHERE],
    }  # fmt: skip


if __name__ == "__main__":
    command(main, "work_precision")
