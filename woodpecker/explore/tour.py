"""The guided tour: ten states that follow the paper's figures, each with two sentences."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from woodpecker import Toy
from woodpecker.explore.state import PageState

STABLE = -0.5294719671  # rad, of the stable motion at eps_N1 = 0.5


@dataclass(frozen=True, slots=True)
class TourStep:
    """One step of the guided tour."""

    title: str  # a few words
    figure: str  # figure of the paper that it follows
    text: str  # two sentences
    views: tuple[str, ...]  # views that are highlighted
    state: PageState  # state of the page


def _of(title: str, figure: str, text: str, views: tuple[str, ...], **changes: Any) -> TourStep:
    state = PageState(phi_s=STABLE, toy=Toy(**changes.pop("toy", {})))
    return TourStep(title, figure, text, views, replace(state, **changes))


_STEPS = (
    _of(
        "Down the pole", "Figure 4",
        "The toy repeats one motion: it slips, falls, hammers at the pole and jams again, and each "
        "time it is some 19 mm lower. The histories show one period of 0.146 s; play it slowly, or "
        "drag the instant.",
        ("toy", "motion"),
    ),
    _of(
        "Jumps of velocity", "Figure 5",
        "The bird's phase portrait closes after a period. The broken strokes are impacts: there "
        "the velocity jumps, by the beak (orange) and by the edges of the sleeve (violet, green).",
        ("portrait",),
    ),
    _of(
        "Every impact moves everything", "Figure 6",
        "The sleeve's portrait has the same strokes, also where only the beak strikes. The mass "
        "matrix is full: an impulse at one contact changes all three velocities.",
        ("portrait",), portrait="phi_m",
    ),
    _of(
        "A word for a return", "Figure 7",
        "The events of a return in their order are its word: slip S, detachment D, impact I, "
        "jamming J, each with its contact (1 beak, 2 lower edge, 3 upper edge). Hover over an "
        "impact to read its impulses.",
        ("word", "toy"),
    ),
    _of(
        "From return to return", "Figure 8",
        "The map takes the angle at which the sleeve jams to that of the next time; where it meets "
        "the diagonal the motion repeats. It jumps where two impacts change their order, and has "
        "two dips that lead to free fall.",
        ("map",), periodic=False, phi_s=-1.6, steps=30,
    ),
    _of(
        "A softer beak", "Figure 9",
        "Over the restitution of the beak the motion is a branch: solid where stable, broken where "
        "not. At C it meets a jump of the map and ends, but the jump still crosses the diagonal "
        "(dotted) and can be followed like a solution.",
        ("diagram", "graph"), toy={"eps_n1": 0.3}, phi_s=-0.586,
    ),
    _of(
        "Two returns", "Figure 10",
        "A motion of two returns is a fixed point of P₂, and passes the section twice: such "
        "branches come in pairs. Jump crossings of P₂ do not, as the paper found at A.",
        ("diagram", "map"), toy={"eps_n1": 0.7}, phi_s=-0.56, order=2,
    ),
    _of(
        "Near the point A", "Figure 11",
        "Close to A the map has an unstable fixed point beside its jump, with a slope of -1.30. "
        "Step through P₁ to P₄: each crosses the diagonal at a jump of its own.",
        ("map",), toy={"eps_n1": 0.125}, phi_s=-0.853, window=(-1.0, -0.7),
    ),
    _of(
        "The point A itself", "Figure 12",
        "At 0.112 the unstable branch meets the jump: it folds into a jump crossing of P₁, and a "
        "jump crossing of P₂ starts. A model of two straight lines has just that; pwmap explore "
        "shows it exactly.",
        ("map", "diagram"), toy={"eps_n1": 0.113}, phi_s=-0.8823, window=(-1.0, -0.7),
    ),
    _of(
        "The law of impact decides", "Figures 8 to 11",
        "With Coulomb's law contact by contact, the textbook's, another map follows, and A moves "
        "to 0.042. The paper's figures follow from the other law, which bounds friction by the sum "
        "of both normal impulses: switch between them.",
        ("map", "law"), toy={"expansion_friction": "separate"},
    ),
)  # fmt: skip

TOUR = tuple(
    replace(step, state=replace(step.state, tour=k)) for k, step in enumerate(_STEPS, start=1)
)
