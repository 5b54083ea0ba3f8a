"""Loads the system that is explored and compiles its motions, for jobs to be forked from."""

import os
from contextlib import suppress

from woodpecker.explore.system_model import answers
from woodpecker.explore.system_state import first_state

if path := os.environ.get("WOODPECKER_EXPLORED"):
    with suppress(ValueError, ArithmeticError):  # said again by the job of the page
        for _ in answers(first_state(path)):
            pass
