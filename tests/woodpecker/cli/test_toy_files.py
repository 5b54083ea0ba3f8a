"""A toy in a file: written by a command, read by all of them, changed by single options."""

import json
import math
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from woodpecker import Toy
from woodpecker.cli.app import app
from woodpecker.cli.toys import read_toy, write_toy
from woodpecker.mechanics.toy import ExpansionFriction

SHORT = ("simulate", "--phi-s", "-0.6", "--t-end", "0.02")


def run(*arguments: str) -> Any:
    return CliRunner().invoke(app, [*arguments])


def test_a_toy_comes_back_to_the_last_bit(tmp_path: Path) -> None:
    law = ExpansionFriction.SEPARATE
    for toy in (Toy(), Toy(eps_n1=0.1 + 0.2, mu_2=1 / 3, pole=1.5, expansion_friction=law)):
        write_toy(tmp_path / "toy.json", toy)
        assert read_toy(tmp_path / "toy.json") == toy
    assert math.isinf(Toy().pole)  # which JSON cannot say


@pytest.mark.nightly
def test_options_change_single_values_of_a_file(tmp_path: Path) -> None:
    first, second = tmp_path / "first.json", tmp_path / "second.json"
    out = ("--out", str(tmp_path / "out"))
    assert run(*SHORT, "--eps-n1", "0.3", "--save-toy", str(first), *out).exit_code == 0
    assert read_toy(first) == Toy(eps_n1=0.3)
    assert run(*SHORT, "--toy", str(first), "--mu-2", "0.31", "--save-toy", str(second),
               *out).exit_code == 0  # fmt: skip
    assert read_toy(second) == Toy(eps_n1=0.3, mu_2=0.31)
    default = str(Toy().eps_n1)  # typed, and so no default: it wins over the file
    run(*SHORT, "--toy", str(first), "--eps-n1", default, "--save-toy", str(second), *out)
    assert read_toy(second) == Toy()
    assert read_toy(tmp_path / "out" / "about_simulate.json") == Toy()


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("# README", "this is no JSON: Expecting value"),
        ('{"toy": {"eps_n1": 0.3', "this is no JSON: Expecting ',' delimiter"),
        ("[1]", "an object with an entry 'toy' is expected, got [1]"),
        ("null", "an object with an entry 'toy' is expected, got None"),
        ("{}", "an object with an entry 'toy' is expected, got {}"),
        ('{"toy": []}', "'toy' must be an object with values by name, got []"),
        (json.dumps({"toy": {"m_m": 10**400}}), "m_m must be below 1.8e308, got about 1e+400"),
        ('{"toy": {"eps": 0.3}}', "unknown parameter 'eps'"),
        ('{"toy": {"mu_2": 0.3, "mu_2": 0.31}}', "'mu_2' stands twice"),
        ('{"toy": {"eps_n1": 2}}', "eps_n1 must lie in [0, 1], got 2.0"),
        ('{"toy": {"eps_n1": true}}', "eps_n1 must be a real number, got True"),
        ('{"toy": {"eps_n1": null}}', "eps_n1 must be a real number, got None"),
        ('{"toy": {"eps_n1": "0,3"}}', "eps_n1 must be a real number, got '0,3'"),
        ('{"toy": {"eps_n1": [1]}}', "eps_n1 must be a real number, got [1]"),
        (json.dumps({"toy": {"expansion_friction": "both"}}), "'summed' or 'separate', got 'both'"),
        (json.dumps({"toy": {"expansion_friction": [1]}}), "'summed' or 'separate', got [1]"),
    ],
)
def test_what_is_no_toy_is_refused_in_a_sentence(content: str, reason: str, tmp_path: Path) -> None:
    path = tmp_path / "toy.json"
    path.write_text(content, encoding="utf-8")
    found = run(*SHORT, "--toy", str(path), "--out", str(tmp_path / "out"))
    assert found.exit_code == 2
    assert found.stderr.startswith(f"Error: {path} holds no toy, as --save-toy writes it: ")
    assert reason in found.stderr
    assert run(*SHORT, "--toy", str(tmp_path / "none.json")).exit_code == 2
