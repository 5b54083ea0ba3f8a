"""Verbs that explain calls which do not fit stay what they are."""

import inspect
import pickle
from typing import Any

import pytest

import woodpecker
from pwmap.algebra.arguments import explained

API: Any = woodpecker  # wrong calls are the point here


@explained("as it is")
def _sum(values: list[float]) -> float:
    return float(sum(values))


def test_an_error_from_within_is_left_as_it_is() -> None:
    wrong: Any = 3
    with pytest.raises(TypeError, match=r"^'int' object is not iterable$"):
        _sum(wrong)


def test_verbs_and_data_stay_what_they_are() -> None:
    assert _sum([1.0, 2.0]) == 3.0
    assert list(inspect.signature(API.shoot).parameters)[:3] == ["source", "guess", "order"]
    assert "mu_2" in inspect.signature(API.Toy).parameters
    assert pickle.loads(pickle.dumps(API.shoot)) is API.shoot
    assert pickle.loads(pickle.dumps(API.Toy().replace(mu_2=0.31))) == API.Toy(mu_2=0.31)
