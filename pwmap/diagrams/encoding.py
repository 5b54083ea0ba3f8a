"""Frozen records (dataclasses and NamedTuples) as plain JSON data, and back by their types.

Fields hold numbers, text, bytes, enums, arrays, formulas of sympy, exact numbers and
polynomials, records, and tuples, sets or mappings of these. Floats are the shortest text that reads
back the same; nan and infinities are ``"nan"``, ``"inf"``, ``"-inf"`` in arrays, elsewhere
``{"$numberDouble": "inf"}``. Lists in a field of type ``Hashable`` are read as tuples. Of a union
of record types the one with exactly the names in the file is taken. A field that is excluded from
comparison and has a default is not saved. ``own`` maps further types to functions that write or
read their values.
"""

from __future__ import annotations

import base64
import dataclasses
import json
import math
import types
from collections.abc import Callable, Hashable, Mapping
from enum import Enum
from functools import lru_cache
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np
import sympy
from sympy import QQ
from sympy.polys.rings import PolyElement, PolyRing

from pwmap.algebra.exact import Infinite
from pwmap.algebra.roots import RealRoot
from pwmap.diagrams import formulas

FORMULA = "$formula"  # key of an object that stands for a formula
NUMBER = "$numberDouble"  # key for a number that JSON lacks, named as in MongoDB's Extended JSON
BYTES, SET = "$bytes", "$set"  # keys for bytes and frozensets
Own = Mapping[type, Callable[[Any], Any]]
NOTHING: Own = types.MappingProxyType({})  # no type is written or read by a function of its own


def to_plain(value: Any, own: Own = NOTHING) -> Any:
    """A record, or a value in it, as JSON data; TypeError if it holds anything else."""
    kind: Any = type(value)
    if kind in own:
        return to_plain(own[kind](value))
    if _is_record(kind):
        return {name: to_plain(getattr(value, name), own) for name in _fields(kind)}
    match value:
        case Enum():
            return value.value
        case None | bool() | str() | int():
            return value
        case float() | np.floating():
            return float(value) if math.isfinite(value) else {NUMBER: repr(float(value))}
        case np.bool_() | np.integer():
            return value.item()
        case np.ndarray():
            return _rows(value.tolist())
        case sympy.Basic() | RealRoot() | Infinite() | PolyElement() | PolyRing() | QQ.dtype():
            return {FORMULA: formulas.to_plain(value)}
        case bytes():
            return {BYTES: base64.b64encode(value).decode()}
        case frozenset():
            return {SET: sorted(map(to_plain, value), key=json.dumps)}
        case tuple() | list():
            return [to_plain(each, own) for each in value]
        case Mapping():
            return {name: to_plain(each, own) for name, each in value.items()}
    raise TypeError(f"expected a number, text or formula to save, got {value!r}")


def from_plain(data: Any, kind: Any, own: Own = NOTHING) -> Any:
    """The inverse of :func:`to_plain` for a type; ValueError, TypeError or LookupError if bad."""
    if kind in own:
        return own[kind](data)
    if _is_record(kind):
        return _record(data, kind, own)
    origin, inner = get_origin(kind), get_args(kind)
    if origin in (Union, types.UnionType):
        return None if data is None else from_plain(data, _one_of(inner, data), own)
    if origin is np.ndarray:
        return _array(_checked(data, list), *get_args(inner[1]))
    if origin is tuple:
        rows = _checked(data, list)
        types_of = [inner[0]] * len(rows) if inner[-1] is ... else inner
        return tuple(from_plain(d, t, own) for d, t in zip(rows, types_of, strict=True))
    if origin is Mapping:
        values = _checked(data, dict).items()
        return {name: from_plain(each, inner[1], own) for name, each in values}
    if kind is object or kind is Any:
        return _untyped(data)
    if kind is Hashable:
        found = _untyped(data, tuple)
        hash(found)  # raises a TypeError if it is not hashable
        return found
    if kind is float:
        return _float(data[NUMBER] if isinstance(data, dict) else data)
    return kind(data) if issubclass(kind, Enum) else _checked(_untyped(data), kind)


def _one_of(kinds: tuple[Any, ...], data: Any) -> Any:
    """The type in a union that data belong to: the only one, a record by its names, or any."""
    some = [each for each in kinds if each is not types.NoneType]
    if len(some) == 1:
        return some[0]
    names = set(data)
    return next((each for each in some if _is_record(each) and names == set(_fields(each))), object)


def _untyped(data: Any, rows: type = list) -> Any:
    """JSON data with their formulas and the values that JSON lacks restored."""
    match data:
        case {"$formula": formula}:
            return formulas.from_plain(formula)
        case {"$numberDouble": number}:
            return float(number)
        case {"$bytes": encoded}:
            return base64.b64decode(encoded, validate=True)
        case {"$set": members}:
            return frozenset(_untyped(each, tuple) for each in members)
        case dict():
            return {name: _untyped(each, rows) for name, each in data.items()}
        case list():
            return rows(_untyped(each, rows) for each in data)
    return data


def _is_record(kind: Any) -> bool:
    return dataclasses.is_dataclass(kind) or hasattr(kind, "_fields")  # as a NamedTuple has


def _record(data: Any, kind: Any, own: Own) -> Any:
    fields = _fields(kind)
    if unknown := set(_checked(data, dict)) - set(fields):
        raise ValueError(f"{kind.__name__} has no {', '.join(sorted(unknown))}")
    return kind(**{name: from_plain(each, fields[name], own) for name, each in data.items()})


@lru_cache
def _fields(kind: Any) -> dict[str, Any]:
    hints = get_type_hints(kind)
    if not dataclasses.is_dataclass(kind):
        return hints
    kept = [e for e in dataclasses.fields(kind) if e.init and (e.compare or not _has_default(e))]
    return {each.name: hints[each.name] for each in kept}


def _has_default(field: dataclasses.Field[Any]) -> bool:
    given = (field.default, field.default_factory)
    return any(each is not dataclasses.MISSING for each in given)


def _rows(values: Any) -> Any:
    """Nested lists of floats, with text for those that JSON lacks."""
    if isinstance(values, list):
        return [_rows(each) for each in values]
    return values if math.isfinite(values) else repr(values)


def _array(rows: list[Any], kind: type) -> Any:
    """An array of floats, or of integers or booleans only; TypeError for any other mixture."""
    if kind is np.float64:
        return np.array(_numbers(rows), dtype=float)
    found = np.array(rows)
    if found.dtype.kind != np.dtype(kind).kind:
        raise TypeError(f"expected {kind.__name__}, got {found.dtype}")
    return found.astype(kind)


def _numbers(data: Any) -> Any:
    """The inverse of :func:`_rows`; TypeError for other data."""
    return [_numbers(each) for each in data] if isinstance(data, list) else _float(data)


def _float(data: Any) -> float:
    known = isinstance(data, int | float) or data in ("nan", "inf", "-inf")
    if isinstance(data, bool) or not known:
        raise TypeError(f"expected a number, got {data!r}")
    return float(data)


def _checked(data: Any, kind: type) -> Any:
    if not isinstance(data, kind) or (kind is int and isinstance(data, bool)):
        raise TypeError(f"expected {kind.__name__}, got {type(data).__name__}")
    return data
