"""The five tasks: what each method computes in them, and the error of its result."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from statistics import median
from typing import Any, NamedTuple

from studies.common.clocks import Job, Seconds
from studies.common.laws import CONTACT_BY_CONTACT
from studies.common.motion import GUESS
from studies.peers.cases import (
    DIGITS,
    FIXED_POINT,
    POINTS,
    SAMPLE_IMAGES,
    SAMPLED,
    Scene,
    distance,
    numbers,
    recomputed_fixed_point,
    same_events,
    sample,
    starts,
)
from studies.peers.enclosed import Enclosed, fixed_point_proved
from studies.peers.kernel import PlainPython, first_return_kernel
from studies.peers.peer import LostError, PeerReturn
from studies.peers.siconos_peer import available, first_return_siconos, simulate_siconos
from studies.precision.methods import KERNEL, OURS, PLAIN, PROVER, TWIN, AnyReturn, Plan, Setting
from woodpecker import ReturnMap, Toy, return_map, shoot

MAP, FIXED = "map of 1000 points", "fixed point, multiplier"
BEND = 0.1  # rad; length over which the slope of the map near its fixed point changes


class Answer(NamedTuple):
    """How good a result is."""

    error: float  # rad; of a fixed point also its multiplier's, whichever is larger
    word_right: bool | None  # None if the task has no word
    evaluations: int | None  # of the right-hand side, or steps
    detail: dict[str, float] | None = None


class Entry(NamedTuple):
    """Work of one method on one task, and how its result is judged."""

    method: str
    variant: str
    knob: str
    value: float | None
    work: Callable[[], Any]
    judge: Callable[[Any], Answer]
    clock: Callable[[int], Job] | None = None  # of work in another process
    scale: float = 1.0  # from the work done to the task


def evaluations_of(once: AnyReturn) -> int | None:
    """What a return took; None if that was not counted."""
    return once.evaluations if isinstance(once, PeerReturn) else None


def error_of(once: AnyReturn, exact: str) -> float:
    """Distance from the reference; of an enclosure what is proved: half its width."""
    return once.radius if isinstance(once, Enclosed) else distance(once.phi_s, exact)


def scene_entries(scene: Scene, settings: Iterable[Setting], other: PlainPython) -> Iterator[Entry]:
    """One return of a scene by everyone."""

    def judge(once: AnyReturn) -> Answer:
        right = same_events(once.word, scene.word)
        return Answer(error_of(once, scene.image), right, evaluations_of(once))

    def judge_plain(result: Sequence[Any]) -> Answer:
        images, words = result
        right = same_events(words[0], scene.word)
        return Answer(distance(images[0], scene.image), right, None)

    kernel = partial(first_return_kernel, scene.toy, scene.phi_s)
    yield Entry(KERNEL, "", "", None, kernel, lambda once: judge(once)._replace(evaluations=None))
    ask = partial(other.ask, "studies.peers.kernel:returns", numbers(scene.toy), [scene.phi_s])
    yield Entry(PLAIN, "", "", None, lambda: ask()[0], judge_plain, elsewhere(ask))
    for setting in settings:
        yield Entry(*setting[:4], partial(setting.peer, scene.toy, scene.phi_s), judge)


def siconos_entries(scene: Scene, plan: Plan) -> Iterator[Entry]:
    """The same by Siconos, if it is there. Its time is that of its time loop up to the return."""

    def judge(once: PeerReturn) -> Answer:
        right = same_events(once.word, scene.word)
        return Answer(distance(once.phi_s, scene.image), right, once.evaluations)

    def loop(step: float, _count: int) -> Job:
        def job() -> Seconds:
            run = simulate_siconos(scene.toy, scene.phi_s, float(scene.period), step, every=0)
            return Seconds(run.seconds, run.seconds)

        return job

    for step in () if available() else plan.siconos:
        work = partial(first_return_siconos, scene.toy, scene.phi_s, step)
        yield Entry("Siconos", "", "step", step, work, judge, partial(loop, step))


def map_entries(
    settings: Iterable[Setting], other: PlainPython, one_core: ThreadPoolExecutor, whole: bool
) -> Iterator[Entry]:
    """The map: the compiled kernel at all points, plain Python if ``whole``, others at a few."""
    toy, few, everywhere = CONTACT_BY_CONTACT, sample(), slice(None)
    part = POINTS / len(few)
    known = return_map(toy, few).words  # a test checks these words

    def judge(errors: Sequence[float], words: Iterable[str], evaluations: int | None) -> Answer:
        right = all(map(same_events, words, known))
        return Answer(max(errors), right, evaluations, {"error_median": median(errors)})

    def judge_few(returns: Sequence[AnyReturn]) -> Answer:
        counts = [count for count in map(evaluations_of, returns) if count is not None]
        total = sum(counts) if len(counts) == len(returns) else None
        errors = [error_of(*each) for each in zip(returns, SAMPLE_IMAGES, strict=True)]
        return judge(errors, [once.word for once in returns], total)

    def judge_images(images: Sequence[float], words: Iterable[str]) -> Answer:
        return judge([*map(distance, images, SAMPLE_IMAGES)], words, None)

    chosen = SAMPLED if whole else everywhere
    begin = starts() if whole else few
    ask = partial(other.ask, "studies.peers.kernel:returns", numbers(toy), begin.tolist())

    def judge_whole(map_: ReturnMap) -> Answer:
        return judge_images(map_.phi_s[SAMPLED].tolist(), map_.words[SAMPLED])

    def judge_plain(result: Sequence[Any]) -> Answer:
        return judge_images(result[0][chosen], result[1][chosen])

    compiled = partial(return_map, toy, starts(), executor=one_core)
    yield Entry(KERNEL, "", "", None, compiled, judge_whole)
    scale = 1.0 if whole else part
    yield Entry(PLAIN, "", "", None, lambda: ask()[0], judge_plain, elsewhere(ask), scale)
    for setting in settings:
        few_returns = partial(_returns, setting.peer, toy, few.tolist())
        yield Entry(*setting[:4], few_returns, judge_few, scale=part)


def _returns(
    peer: Callable[[Toy, float], AnyReturn], toy: Toy, points: Sequence[float]
) -> list[AnyReturn]:
    return [peer(toy, x) for x in points]


def fixed_entries(settings: Iterable[Setting], other: PlainPython) -> Iterator[Entry]:
    """The stable cycle and its multiplier, from a guess 5e-4 rad away."""

    def judge(x: Any, multiplier: Any, evaluations: int | None = None) -> Answer:
        detail = {
            "error_phi_s": distance(x, FIXED_POINT.phi_s),
            "error_multiplier": distance(multiplier, FIXED_POINT.multiplier),
        }
        return Answer(max(detail.values()), None, evaluations, detail)

    def judge_proved(radii: Sequence[float]) -> Answer:
        return Answer(max(radii), None, None)

    toy = CONTACT_BY_CONTACT
    yield Entry(KERNEL, "", "", None, partial(shoot, toy, GUESS),
                lambda orbit: judge(orbit.phi_s, orbit.multiplier))  # fmt: skip
    ask = partial(other.ask, "studies.peers.kernel:fixed_point", numbers(toy), GUESS)
    yield Entry(PLAIN, "", "", None, lambda: ask()[0], lambda r: judge(*r[:2]), elsewhere(ask))
    yield Entry(PROVER, "", "", None, partial(fixed_point_proved, toy, GUESS), judge_proved)
    for setting in settings:
        if setting.method not in OURS:
            yield Entry(*setting[:4], partial(newton, setting), lambda r: judge(*r))
        elif setting.method == TWIN and setting.value == DIGITS:
            yield Entry(*setting[:4], recomputed_fixed_point, lambda r: judge(*r[:2]))


def newton(setting: Setting, steps: int = 12) -> tuple[float, float, int]:
    """Fixed point, multiplier and evaluations by Newton's method with difference quotients.

    A peer has no slope, so it is a central difference over the cube root of its noise times a
    tenth of a radian, over which the map bends. It is taken once for the steps and once at the end
    for the multiplier: fresh ones in between only cost.
    """
    spent = 0

    def image(x: float) -> float:
        nonlocal spent
        if not x < CONTACT_BY_CONTACT.phi_s_max:
            raise LostError(f"Newton's method leaves the map, to {x:.3g} rad")
        once = setting.peer(CONTACT_BY_CONTACT, x)
        spent += evaluations_of(once) or 0
        return float(once.phi_s)

    def slope(x: float) -> float:
        h: float = BEND * setting.noise ** (1.0 / 3.0)
        return (image(x + h) - image(x - h)) / (2.0 * h)

    x = GUESS
    steepness = slope(x)
    for _ in range(steps):
        step = (image(x) - x) / (1.0 - steepness)
        x += step
        if abs(step) <= setting.noise:
            break
    return x, slope(x), spent


def elsewhere(ask: Callable[..., tuple[Any, Seconds]]) -> Callable[[int], Job]:
    """Clock of work in another process, which reports its own time."""
    return lambda count: lambda: ask(count=count)[1]
