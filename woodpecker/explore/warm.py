"""Loads the modules of the explorer and its jobs, and compiles the kernel."""

from woodpecker import Toy, first_return, shoot, simulate
from woodpecker.explore import branches, exports, model  # noqa: F401

simulate(Toy(), -0.53, 0.2)
first_return(Toy(), -0.53)
shoot(Toy(), -0.53)
