"""Maps of the toy and of tests can be sent, copied and shared between threads."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import lines
import numpy as np
import pytest
from maps import paper

from woodpecker import (
    LocalModel,
    Toy,
    iterate,
    iterated,
    local_model,
    sampled,
    toy_map,
    toy_samples,
)
from woodpecker.piecewise.maps import LabelledMap, windowed
from woodpecker.piecewise.partition import SampledMap


def pickled(value: Any) -> Any:
    return pickle.loads(pickle.dumps(value))


Way = Callable[[Any], Any]
WAYS = pytest.mark.parametrize("way", [pickled, copy.deepcopy])
X = np.linspace(-2.4, 0.05, 20)


def labelled() -> list[LabelledMap]:
    toy = Toy(mu_2=0.31)
    one = toy_map(toy)
    return [one, toy_map(toy, "m_m"), windowed(one, (-1.0, -0.3)), iterate(one, 2)]


def samples() -> list[SampledMap]:
    one = toy_samples(Toy(mu_2=0.31))
    return [one, iterated(one, 2, (-2.0, -0.3)), sampled(paper())]


def seen(map_: LabelledMap) -> str:
    p = 0.003 if getattr(map_, "parameter", "") == "m_m" else 0.4
    return repr([map_(x, p) for x in X.tolist()])


def swept(map_: SampledMap) -> list[object]:
    found = map_.sweep(X, 0.4)
    words = [map_.words[k] for k in found.words]
    return [words, *(column.tobytes() for column in (*found[:4], found.defined))]


@WAYS
@pytest.mark.parametrize("used", [False, True])
def test_labelled_maps(way: Way, used: bool) -> None:
    for map_ in labelled():
        before = seen(map_) if used else ""
        again = way(map_)
        assert again == map_
        assert seen(again) == (before or seen(map_))


@WAYS
@pytest.mark.parametrize("used", [False, True])
def test_sampled_maps(way: Way, used: bool) -> None:
    for map_ in samples():
        if used:
            map_.sweep(X[::-1].copy(), 0.4)  # words have other numbers now
        again = way(map_)
        assert again == map_
        assert list(again.words) == []
        assert swept(again) == swept(map_)


@WAYS
def test_local_models(way: Way) -> None:
    model = local_model(lines.two_lines(), 0.0, 0.0, orders=(1, 2))
    again: LocalModel = way(model)
    assert (again.x, again.p, again.speed) == (model.x, model.p, model.speed)
    assert (again.starts, again.point) == (model.starts, model.point)
    assert again.border.cause == model.border.cause
    assert str(again.map.at({"q": 1}).iterate(2)) == str(model.map.at({"q": 1}).iterate(2))


def test_a_map_that_threads_share_gives_each_its_own_answer() -> None:
    map_, points = toy_map(Toy()), [(float(x), p) for p in (0.1, 0.4, 0.7) for x in X] * 4
    expected = [repr(map_(x, p)) for x, p in points]
    with ThreadPoolExecutor(4) as threads:
        found = list(threads.map(lambda point: repr(map_(*point)), points))
    assert found == expected


def test_maps_are_equal_if_their_toys_and_parameters_are() -> None:
    assert toy_map(Toy()) == toy_map(Toy())
    assert len({toy_map(Toy()), toy_map(Toy(mu_2=0.3)), toy_map(Toy(), "m_m")}) == 2
    assert toy_samples(Toy()) != toy_samples(Toy(mu_2=0.31))
    with pytest.raises(TypeError, match="unknown parameter 'eps'"):
        toy_samples(Toy(), "eps")
