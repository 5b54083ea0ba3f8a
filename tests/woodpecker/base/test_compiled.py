"""With numba and without: which kernel runs, and who is told that it is compiled."""

import logging
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from scenes import ROOT, in_another_process

from woodpecker import Toy, first_return
from woodpecker.base import compiled

ASK = """
from woodpecker.base.compiled import COMPILED
from woodpecker import first_return
from woodpecker import Toy
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
    flag, phi_s, word = in_another_process(start + ASK, timeout=300.0, **environment).split(" ", 2)
    here = first_return(Toy(), -0.53)
    assert flag == "False"
    assert abs(float(phi_s) - here.phi_s) < 1e-14  # roundings of sines
    assert word.strip() == repr(here.word)


USE = """
from woodpecker.base import compiled
from woodpecker.motion import guards
from woodpecker.simulation.calls import compute
compiled.announce(compute)  # as the first return does
print(guards.stumpff(0.0, 0.0, 2.0)[1], type(compute.stats.cache_path).__name__)
"""


def without_cache(tmp_path: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a copy of the packages beside which nothing can be written, not even by root.

    A file stands where each folder of the cache should be, beside the code and for the user.
    """
    for package in ("pwmap", "woodpecker"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / package, tmp_path / package, ignore=ignored)
    for code in (tmp_path / "woodpecker").rglob("__init__.py"):
        code.with_name("__pycache__").touch()
    blocked = str(tmp_path / "woodpecker" / "diagrams.py" / "cache")
    places = {"HOME": blocked, "XDG_CACHE_HOME": blocked, "NUMBA_CACHE_DIR": ""}
    own = {"PYTHONPATH": str(tmp_path), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", USE],
        capture_output=True, text=True, timeout=120.0, cwd=tmp_path,
        env=os.environ | places | own | environment,
    )  # fmt: skip


@pytest.mark.nightly
@pytest.mark.skipif(not compiled.COMPILED, reason="there is no cache without numba")
def test_without_a_folder_for_the_cache_the_kernel_is_compiled_anew(tmp_path: Path) -> None:
    done = without_cache(tmp_path)
    assert (done.stdout, done.returncode) == ("2.0 NoneType\n", 0)
    assert done.stderr.count("NUMBA_CACHE_DIR") == 1
    assert done.stderr.strip().count("\n") == 0


@pytest.mark.slow
@pytest.mark.skipif(not compiled.COMPILED, reason="there is no cache without numba")
def test_a_folder_for_the_cache_can_be_given(tmp_path: Path) -> None:
    done = without_cache(tmp_path, NUMBA_CACHE_DIR=str(tmp_path / "given"))
    assert (done.stdout, done.returncode) == ("2.0 str\n", 0)
    assert "NUMBA_CACHE_DIR" not in done.stderr


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
    assert caplog.messages == [
        "compiling the kernel; this happens once and takes twenty to forty seconds"
    ]


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


@pytest.mark.nightly
@pytest.mark.skipif(not compiled.COMPILED, reason="there is no cache without numba")
def test_a_change_in_one_file_renews_what_others_have_cached_of_it(tmp_path: Path) -> None:
    """A small package with this one's way to compile: outer calls inner, of another file."""
    package = tmp_path / "small"
    package.mkdir()
    shutil.copy(compiled.__file__, package / "compiled.py")
    (package / "__init__.py").touch()
    inner = "from small.compiled import jit\n\n@jit\ndef inner(x):\n    return {} * x\n"
    outer = "from small.inner import inner\n\n@jit\ndef outer(x):\n    return inner(x)\n"
    (package / "outer.py").write_text("from small.compiled import jit\n" + outer)

    def called(factor: int) -> tuple[str, bool]:
        """The value, and whether it was announced that it is compiled."""
        (package / "inner.py").write_text(inner.format(factor))
        environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])}
        code = "from small import compiled; from small.outer import outer; "
        code += "compiled.announce(outer); print(outer(1.0))"
        command = [sys.executable, "-c", code]
        run = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        return run.stdout.strip(), "compiling the kernel" in run.stderr

    assert [called(factor) for factor in (2, 2, 3)] == [
        ("2.0", True),
        ("2.0", False),
        ("3.0", True),
    ]


KERNEL = """
import logging, sys
logging.basicConfig(format="%(message)s")
from woodpecker.base.compiled import jit

@jit
def doubled(x):
    return 2.0 * x

before = sys.argv[1:]
if before:
    import resource, signal
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (64, 64))  # as a full disk
print(doubled(1.5), sum(doubled.stats.cache_hits.values()))
"""


@pytest.mark.nightly
@pytest.mark.skipif(not compiled.COMPILED, reason="there is no cache without numba")
@pytest.mark.skipif(sys.platform == "win32", reason="resource is for others")
def test_a_cache_that_is_damaged_or_full_is_no_obstacle(tmp_path: Path) -> None:
    """It is named, and written anew where it can be."""
    script, folder = tmp_path / "kernel.py", tmp_path / "cache"
    script.write_text(KERNEL, encoding="utf-8")

    def call(*arguments: str) -> tuple[str, str]:
        done = subprocess.run(
            [sys.executable, str(script), *arguments], capture_output=True, text=True, timeout=120,
            env=os.environ | {"PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(folder)},
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return done.stdout.strip(), done.stderr

    assert call() == ("3.0 0", "")
    assert call() == ("3.0 1", "")
    (code,), (index,) = folder.rglob("*.nbc"), folder.rglob("*.nbi")
    content = bytearray(code.read_bytes())
    content[len(content) // 2] ^= 4
    for file, damaged in ((code, bytes(content)), (index, b"")):
        file.write_bytes(damaged)
        result, said = call()
        assert result == "3.0 0"
        assert f"the cache of the compiled kernel in {code.parent} is damaged" in said
        assert said.count("\n") == 1
        assert call() == ("3.0 1", "")
    code.unlink()
    index.unlink()
    result, said = call("full")
    assert result == "3.0 0"
    assert f"{code.parent} cannot be written" in said
