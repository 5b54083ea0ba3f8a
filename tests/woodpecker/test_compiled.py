"""With numba and without: which kernel runs, and who is told that it is compiled."""

from __future__ import annotations

import logging
from pathlib import Path
from types import SimpleNamespace

import pytest
from scenes import in_another_process

from woodpecker import compiled
from woodpecker.returns import first_return
from woodpecker.toy import Toy

ASK = """
from woodpecker.compiled import COMPILED
from woodpecker.returns import first_return
from woodpecker.toy import Toy
result = first_return(Toy(), -0.53)
print(COMPILED, repr(result.phi_s), repr(result.word))
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("start", "environment"),
    [("import sys; sys.modules['numba'] = None", {}), ("", {"NUMBA_DISABLE_JIT": "1"})],
    ids=["not installed", "switched off"],
)
def test_without_numba_the_kernel_is_plain_python(start: str, environment: dict[str, str]) -> None:
    flag, phi_s, word = in_another_process(start + ASK, timeout=60.0, **environment).split(" ", 2)
    here = first_return(Toy(), -0.53)
    assert flag == "False"
    assert abs(float(phi_s) - here.phi_s) < 1e-14  # roundings of sines
    assert word.strip() == repr(here.word)


@pytest.fixture
def function(tmp_path: Path) -> SimpleNamespace:
    """What numba's dispatcher shows of a function ``sweep`` in a file kernel.py."""
    code = SimpleNamespace(co_filename="/somewhere/kernel.py")
    python = SimpleNamespace(__name__="sweep", __code__=code)
    return SimpleNamespace(stats=SimpleNamespace(cache_path=str(tmp_path)), py_func=python)


def test_compilation_is_announced_once(
    function: SimpleNamespace, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(compiled, "_announced", False)
    with caplog.at_level(logging.WARNING, logger="woodpecker"):
        compiled.announce(function)
        compiled.announce(function)
    assert caplog.messages == ["compiling the kernel; this happens once and takes some seconds"]


def test_a_cached_kernel_is_not_announced(
    function: SimpleNamespace,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    monkeypatch.setattr(compiled, "_announced", False)
    (tmp_path / "kernel.sweep-750.py311.nbi").touch()
    compiled.announce(function)
    assert caplog.messages == []
