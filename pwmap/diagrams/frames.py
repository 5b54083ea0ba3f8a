"""Columns as a pandas DataFrame; pandas is an optional dependency."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from typing import Any

import numpy as np

DataFrame = Any  # pandas.DataFrame, where pandas is installed
Column = Sequence[Any] | np.ndarray[Any, Any]


def dataframe(columns: Mapping[str, Column]) -> DataFrame:
    """Columns of one length as a pandas.DataFrame; ImportError without pandas."""
    try:
        import pandas as pd
    except ImportError:
        raise ImportError(
            "a dataframe needs pandas, which is not installed: pip install 'woodpecker-toy[data]'"
        ) from None
    return pd.DataFrame({name: _values(column) for name, column in columns.items()})


def unique_names(names: Iterable[str], taken: Iterable[str]) -> list[str]:
    """Names of columns, with an underscore appended to one that is taken, as in ``kind_``."""
    found, every = list[str](), set(taken)
    for name in names:
        while name in every:
            name += "_"
        found.append(name)
        every.add(name)
    return found


def _values(column: Column) -> Column:
    """A copy, so that changes of a caller's frame do not reach the diagram."""
    return np.array(column) if isinstance(column, np.ndarray) else list(column)


def joined(tables: Sequence[Mapping[str, Column]], names: Iterable[str]) -> dict[str, Column]:
    """Stack the columns of some names of several tables."""
    return {name: [*chain.from_iterable(table[name] for table in tables)] for name in names}
