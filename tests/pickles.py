"""Ways to copy an object, for tests that its content survives."""

import pickle
from collections.abc import Callable
from typing import Any

Way = Callable[[Any], Any]


def pickled(value: Any) -> Any:
    """What arrives in another process."""
    return pickle.loads(pickle.dumps(value))
