"""The examples of the engine's docstrings print what they say."""

import doctest
from importlib import import_module

import pytest
from pages import OPTIONS

FILES = ("engine.formulas", "engine.two_parameters", "search.connected")


@pytest.mark.parametrize("name", FILES)
def test_examples(name: str) -> None:
    module = import_module(f"woodpecker.{name}")
    found = doctest.testmod(module, optionflags=OPTIONS)
    assert found.attempted > 0
    assert found.failed == 0
