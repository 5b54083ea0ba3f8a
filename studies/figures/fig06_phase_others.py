"""Figure 6 of the paper: phase portraits of the sleeve and of the fall.

    python -m studies.figures.fig06_phase_others [--fast] [--out DIR]

On the left the sleeve between its two contacts; on the right the speed of the fall over the angle
of the bird. The numbers are those of Figure 7. The paper's text does not say which portraits it
shows (see :mod:`studies.figures.fig05_phase_woodpecker`).
"""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from studies.common.motion import cycle, extremes
from studies.common.portraits import portrait
from studies.common.record import Results, command
from studies.common.style import canvas, keep
from woodpecker import Trajectory

OF_SLEEVE = ((20, 6), None, (8, 0), (-7, -5), (8, 0), (8, -5), (7, -7), None)  # see Side
OF_FALL = ((0, 8), (2, 9), (-8, -4), (4, -8), (-8, -5), (9, -4), (-8, 0), (0, 8))


def main(fast: bool = False, out: Path | None = None) -> Results:
    """Shoot the cycle and draw the velocities of sleeve and fall.

    Parameters
    ----------
    fast
        Makes no difference: the study takes milliseconds.
    out
        Folder for ``fig06.png``.

    Returns
    -------
    dict
        ``period`` [s]; ``phi_m``, ``dphi_m``, ``dy``: least and largest value [rad], [rad/s],
        [m/s].
    """
    orbit, motion = cycle()
    if out is not None:
        keep(draw(motion), out / "fig06.png")
    return {
        "period": orbit.period,
        "phi_m": extremes(motion.q[:, 1]),
        "dphi_m": extremes(motion.u[:, 1]),
        "dy": extremes(motion.u[:, 0]),
    }


def draw(trajectory: Trajectory) -> Figure:
    """Sleeve and fall."""
    figure, (sleeve, fall) = canvas(3.7, 1, 2)
    limits = (-trajectory.toy.phi_m_max, trajectory.toy.phi_m_max)
    sleeve.margins(x=0.1)
    portrait(trajectory, ("phi_m", "dphi_m"), OF_SLEEVE, sleeve, limits)
    portrait(trajectory, ("phi_s", "dy"), OF_FALL, fall, legend=False)
    return figure


if __name__ == "__main__":
    command(main, "fig06_phase_others")
