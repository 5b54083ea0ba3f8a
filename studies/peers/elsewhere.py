"""Programs that run in another Python than the project's."""

from __future__ import annotations

import os
import subprocess
from functools import cache


@cache
def why_not(python: str, name: str, imports: str) -> str:
    """Empty if an interpreter can import what a program needs, otherwise why not, as a sentence.

    Parameters
    ----------
    python
        The interpreter.
    name
        The program, as it is called.
    imports
        The modules, parted by commas.
    """
    try:
        asked = subprocess.run(
            [python, "-W", "ignore", "-c", f"import {imports}"],
            env=environment(), capture_output=True, text=True, timeout=60,
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"{name} cannot be asked for: {error}"
    if asked.returncode:
        reason = (asked.stderr.strip().splitlines() or ["no reason given"])[-1]
        return f"{python} cannot import {name}: {reason}"
    return ""


def environment() -> dict[str, str]:
    """The packages of this process are not those of the other Python."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
