"""Loads the system that is explored and compiles its first motion, for jobs to be forked from."""

import os

from woodpecker.explore.system_model import SystemModel
from woodpecker.explore.system_state import explored, first_state

if path := os.environ.get("WOODPECKER_EXPLORED"):
    given = explored(path)
    SystemModel(given).motion(first_state(given))
