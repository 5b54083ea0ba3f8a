"""Returns, continuation and diagrams of the toy, warm.

Times are CPU times of one process: they can be compared whatever else the machine does.
"""

import time

import numpy as np

from woodpecker import (
    Search,
    Toy,
    bifurcation_diagram,
    continuation,
    first_return,
    return_map,
    shoot,
)

ANGLES = np.linspace(-2.4, -0.3, 1000)  # rad


class Returns:
    """One return, and a map."""

    timer = staticmethod(time.process_time)

    def setup(self) -> None:
        """Compile the kernel."""
        first_return(Toy(), -0.53)

    def time_one_return(self) -> None:
        """With its derivatives."""
        first_return(Toy(), -0.53)

    def time_a_map_of_a_thousand_points(self) -> None:
        """The sum over all cores."""
        return_map(Toy(), ANGLES)


class Branches:
    """The main job, and a whole diagram."""

    timeout = 300.0
    timer = staticmethod(time.process_time)

    def setup(self) -> None:
        """Find the start, and compile the kernel."""
        self.toy = Toy()
        self.orbit = shoot(self.toy, -0.53)

    def time_shooting(self) -> None:
        """The paper's motion."""
        shoot(self.toy, -0.53)

    def time_continuation(self) -> None:
        """All that is connected with the paper's motion."""
        continuation(self.toy, self.orbit, "eps_n1", span=(0.0, 1.0))

    def time_a_whole_diagram(self) -> None:
        """Order one, in a tenth of the range, by one process."""
        few = Search(slices=7)
        bifurcation_diagram(self.toy, "eps_n1", (0.1, 0.2), (1,), search=few, workers=1)
