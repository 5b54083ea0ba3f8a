"""Common to all studies: the command line, the JSON file, and a record of the machine."""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
from collections.abc import Callable
from importlib import metadata
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
PACKAGES = ("numpy", "scipy", "sympy", "matplotlib", "networkx", "numba", "mpmath", "python-flint")
Results = dict[str, Any]
Study = Callable[[bool, Path | None], Results]


def command(study: Study, name: str) -> None:
    """Run a study from the command line: ``[--fast] [--out DIR]``; print and keep its numbers."""
    parser = argparse.ArgumentParser(description=(study.__doc__ or name).splitlines()[0])
    parser.add_argument("--fast", action="store_true", help="a small version, in seconds")
    parser.add_argument("--out", type=Path, help=f"folder for {name}.json and the pictures")
    options = parser.parse_args()
    if options.out is not None:
        options.out.mkdir(parents=True, exist_ok=True)
    results = study(options.fast, options.out)
    print(json.dumps(results, indent=2))
    if options.out is not None:
        save(results, name, options.out)


def save(results: Results, name: str, out: Path) -> Path:
    """Write the numbers of a study, with what it ran on, to ``out / name.json``."""
    path = out / f"{name}.json"
    text = json.dumps({**results, "environment": environment()}, indent=2, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")
    return path


def environment() -> dict[str, str]:
    """Machine, versions and commit."""
    cpu = Path("/proc/cpuinfo")
    lines = cpu.read_text(encoding="utf-8").splitlines() if cpu.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return {
        "machine": f"{platform.system()} {platform.machine()}",
        "processor": names[0] if names else platform.processor(),
        "cores": str(os.cpu_count()),
        "commit": commit(),
        "python": platform.python_version(),
        **{package: version(package) for package in PACKAGES},
    }


def environ(**changes: str) -> dict[str, str]:
    """Environment of a process that imports what this one imports."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), **changes}


def version(package: str) -> str:
    """Version of an installed package."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def commit() -> str:
    """The commit of the working tree, marked if files of it were changed."""
    ask = ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--exclude=*"]
    try:
        asked = subprocess.run(ask, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return asked.stdout.strip()
