"""The mechanisms of :mod:`woodpecker.engine`, each with a trivial replacement."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from studies.common.switched_off import Mechanism, argument, gives
from woodpecker.engine.maps import first_piece_of
from woodpecker.engine.orbits import orbit_of


def _no_bend(curve: Any, a: Any, *_: Any) -> Any:
    return np.zeros(len(a.tangent))


def _at_once(problem: Any, orbit: Any, step: Any) -> Any:
    return problem.moved(orbit, step), False


def _at_border(near: Any, x: Any, p: Any, _: Any) -> Any:
    return near.piece.at(x, p)


def _at_unknowns(crossing: Any, unknowns: Any) -> Any:
    (n, d), k = crossing.x.shape, len(crossing.p)
    pieces = [*(image.piece for image in crossing.images[:-1]), first_piece_of(crossing.images[-1])]
    return orbit_of(pieces, unknowns[: n * d].reshape(n, d), unknowns[n * d : n * d + k])


def _left_there(arc: Any, _: Any, outer: Any) -> Any:
    return arc, outer


ENDS: Final = "engine.ends"
FOLLOWING: Final = "engine.following"

MECHANISMS: Final = (
    # --- Following a curve
    Mechanism("engine.curves", "SolutionCurve._bend", _no_bend, "predict along a cubic"),
    Mechanism(FOLLOWING, "to_end", gives(None), "step just to the end of the span"),
    Mechanism(FOLLOWING, "_closes", gives(False), "see a closed branch"),
    Mechanism("engine.curves", "SolutionCurve.agrees", gives(True), "ask the map for its piece"),
    Mechanism("engine.curves", "SAME_VALUE", math.inf, "tell two solutions of a piece apart"),
    Mechanism(FOLLOWING, "KEPT_TURN", 1.0, "keep clear of the largest turn"),
    Mechanism(FOLLOWING, "SUDDEN_TURN", math.inf, "see a leap to another solution by its turn"),
    # --- What ends an arc
    Mechanism(FOLLOWING, "_is_on_other_curve", gives(False), "refuse samples of other curves"),
    Mechanism(FOLLOWING, "_points_merge", gives(False), "keep a cycle doubled"),
    Mechanism(ENDS, "LEAST_RATE", -math.inf, "see a margin that is not the same all along"),
    Mechanism("engine.curves", "pulled_inside", argument(0), "keep guesses inside of a root"),
    Mechanism(FOLLOWING, "_leaps", gives(False), "see a margin of another solution"),
    Mechanism(FOLLOWING, "_differs_between", gives(False), "look halfway"),
    Mechanism(FOLLOWING, "extended_to_root", gives(None), "end at a root by the piece beyond"),
    Mechanism(ENDS, "_hides", gives(False), "go closer before a root"),
    Mechanism(ENDS, "_has_leapt", gives(False), "see a margin that leapt elsewhere"),
    Mechanism(ENDS, "_told_apart", argument(0), "no flip where a fold is"),
    Mechanism(ENDS, "_look_for_dips", gives(None), "see a margin that dips"),
    Mechanism(ENDS, "_is_rounding", gives(False), "see what a step meets right at its end"),
    Mechanism(ENDS, "_sharper_test", argument(0), "locate a fold by its multiplier"),
    Mechanism(ENDS, "_solved", gives(None), "locate ends by Newton's method"),
    Mechanism(ENDS, "BEGINS", 0.0, "ignore what a curve begins with"),
    Mechanism(ENDS, "COARSE", 0.0, "go closer where ends are unclear"),
    Mechanism(ENDS, "ZERO_REMAINDER", math.inf, "refuse a pole for a zero"),
    Mechanism("engine.curves", "Arc._left", gives(0.0), "say how well a root's end is located"),
    # --- Newton's method
    Mechanism("engine.newton", "Problem._along_borders", gives(None), "roots along their border"),
    Mechanism("engine.newton", "_damped_step", _at_once, "halve steps to where there is no map"),
    Mechanism("engine.newton", "STALLED", 0.0, "stop at what rounding leaves of steep maps"),
    Mechanism("engine.newton", "SOLVED", 0.0, "leave out a last step that changes nothing"),
    Mechanism("engine.newton", "_is_met", gives(True), "see that steps ended without an orbit"),
    Mechanism("engine.newton", "Problem.is_steep", gives(False), "solve on after shortened steps"),
    Mechanism("engine.orbits", "OnBorder.is_near", gives(True), "stay with a margin's solution"),
    Mechanism(
        "engine.orbits", "OnBorder.moved_to_margin", argument(1), "stay on a level of a margin"
    ),
    Mechanism(
        "engine.curves", "head_of", _at_unknowns, "keep crossings inside of a grazing border"
    ),
    Mechanism("engine.newton", "branch_point", gives(None), "locate a branch point"),
    # --- From arc to arc
    Mechanism("engine.tracing", "_at_nearest", argument(0), "end at a border within rounding"),
    Mechanism("engine.rooted", "_moved_to", _left_there, "locate a root by the piece beyond"),
    Mechanism(
        "engine.rooted", "_with_slopes_inside", argument(0), "tell steep slopes from rounding"
    ),
    Mechanism("engine.rooted", "_at_limit", argument(0), "locate a root at a jump by its limit"),
    Mechanism(
        "engine.rooted", "_runs_along_border", gives(False), "see a border that is hugged all along"
    ),
    Mechanism("engine.arrivals", "_has_ended", gives(False), "see that a crossing has ended"),
    Mechanism("engine.arrivals", "_closes_in", gives(True), "leave a corner on what comes to it"),
    Mechanism("engine.tracing", "_changes_stability", gives(False), "see a kink that destabilises"),
    Mechanism("engine.tracing", "_cycles_beyond", gives(None), "cross continuous borders at once"),
    Mechanism("engine.tracing", "_from_beside", gives(None), "start beside a root by its margin"),
    Mechanism("engine.tracing", "round_corner", gives(None), "leave a corner on another border"),
    Mechanism("engine.tracing", "leads_back", gives(False), "never go back on the same border"),
    Mechanism("engine.tracing", "DENSE", 0.0, "pass where words of limits are dense"),
    Mechanism("engine.tracing", "over_accumulation", gives(None), "pass where borders accumulate"),
    Mechanism("engine.tracing", "crossing_beyond", gives(None), "pass the same with a crossing"),
    Mechanism("engine.tracing", "_with_other_limit", gives(None), "change one limit's word"),
    Mechanism("engine.tracing", "beside", argument(0), "begin beside a special point"),
    Mechanism(
        "engine.tracing", "_on_same_sides", gives(True), "begin before the next fold or flip"
    ),
    Mechanism(
        "engine.tracing", "extended_round_bend", gives(None), "round bends sharper than any step"
    ),
    Mechanism("engine.tracing", "_at_flip", gives(None), "end doubled cycles at the single flip"),
    Mechanism("engine.tracing", "MORE_SOLVES", 0, "reach a curved border slowly"),
    Mechanism("engine.tracing", "_home", gives(None), "close round corners"),
    Mechanism("engine.tracing", "_off_border", gives(None), "begin on a level of a margin"),
    Mechanism("engine.tracing", "FIRST_STEP_BEYOND", 0.0, "a least first step beyond a border"),
    Mechanism("engine.tracing", "_first_step", gives(math.inf), "a first step as bends allow"),
    # --- What starts at a point
    Mechanism("engine.germs", "PART_BEYOND_BORDER", 0.0, "lead beyond where borders cross"),
    Mechanism(
        "engine.germs", "_locates_border_worse", gives(False), "locate a root from its other side"
    ),
    Mechanism("engine.germs", "_is_taken_ahead", gives(True), "ask where pieces have no margin"),
    Mechanism("engine.germs", "_opening", gives(None), "start where a jump vanishes"),
    Mechanism("engine.germs", "meets_border", gives(False), "see a crossing at a corner"),
    Mechanism("engine.germs", "least_period", argument(0), "run through a cycle once"),
    Mechanism("engine.germs", "cycle_through", gives(None), "end a crossing at a cycle"),
    Mechanism("engine.germs", "accumulated", gives(None), "limits of ever thinner pieces"),
    Mechanism("engine.germs", "lost_beyond", gives(""), "say why a limit is lost"),
    # --- What the map takes beside a point
    Mechanism("engine.maps", "DISTANCES", (2.0**-22,), "propose pieces at several distances"),
    Mechanism("engine.maps", "limit", _at_border, "limits where slopes are rounding"),
    Mechanism("engine.maps", "SAME_SOLUTION", 0.0, "tell a value of another solution"),
    Mechanism("engine.maps", "_distances", argument(2), "measure roots by their margin"),
    Mechanism("engine.maps", "root_of", gives(None), "limits at roots of any power"),
)  # fmt: skip
