"""Loads the explored system and compiles its motions, in the process that jobs are forked from."""

import os
from contextlib import suppress

from woodpecker.explore.system_model import answers
from woodpecker.explore.system_state import first_state

if path := os.environ.get("WOODPECKER_EXPLORED"):
    with suppress(ValueError, ArithmeticError):  # the job of the page will report it
        for _ in answers(first_state(path)):
            pass
