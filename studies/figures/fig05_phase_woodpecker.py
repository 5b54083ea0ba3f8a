"""Figure 5 of the paper: phase portrait of the bird in the stable periodic motion.

    python -m studies.figures.fig05_phase_woodpecker [--fast] [--out DIR]

The paper calls Figures 5 and 6 "phase space portraits" without saying of which coordinates. Here
Figure 5 shows the bird, whose angle is also the coordinate of the return map; Figure 6 shows the
sleeve and the fall.
"""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from studies.common.motion import cycle, extremes
from studies.common.portraits import portrait
from studies.common.record import Results, command
from studies.common.style import canvas, keep
from woodpecker import Trajectory

SIDES = ((0, 8), (0, 8), (8, -5), (9, 0), (-9, -3), (-4, 9), (0, 9), (0, -10))  # see Side


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Shoot the cycle and draw the bird's velocity over its angle.

    Parameters
    ----------
    fast
        Makes no difference: the study takes milliseconds.
    out
        Folder for ``fig05.png``.

    Returns
    -------
    dict
        ``period`` [s]; ``phi_s``, ``dphi_s``: least and largest value [rad], [rad/s];
        ``beak``: velocity of the bird before and after the beak strikes [rad/s], and
        ``beak_restitution``, the negative of their ratio.
    """
    orbit, motion = cycle()
    if out is not None:
        keep(draw(motion), out / "fig05.png")
    (strike,) = (event for event in motion.events if event.symbol == "I1")
    before, after = strike.u_before[2], strike.u_after[2]
    return {
        "period": orbit.period,
        "phi_s": extremes(motion.q[:, 2]),
        "dphi_s": extremes(motion.u[:, 2]),
        "beak": (before, after),
        "beak_restitution": -after / before,
    }


def draw(trajectory: Trajectory) -> Figure:
    """Velocity over angle, up to the angle at which the beak strikes."""
    figure, (ax,) = canvas(4.4)
    limits = [trajectory.toy.phi_s_max]
    portrait(trajectory, ("phi_s", "dphi_s"), SIDES, ax, limits)
    return figure


if __name__ == "__main__":
    command(main, "fig05_phase_woodpecker")
