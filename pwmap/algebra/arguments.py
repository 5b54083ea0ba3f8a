"""Arguments of calls: values in messages, checks, and errors for calls that do not fit.

Only the standard library is imported, so that the toy starts fast.
"""

from __future__ import annotations

import math
import operator
import os
import sys
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from numbers import Rational
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")
C = TypeVar("C")

MOST = 10**7  # largest count of values that are kept, for the sake of memory
MOST_COLUMNS = 10**5  # of a picture, which can show some thousand
LONGEST = 100  # characters of a value in a message
LARGEST = 10**LONGEST  # number written with all digits: Python writes 4300 at most

# what repr raises for an object that is half initialised, nested too deep or cannot be shown
NO_TEXT = (ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError)


# --- Values in sentences --------------------------------------------------------------------------


def shortened(text: str, width: int = LONGEST) -> str:
    """A text for a message, with its middle left out if it is longer than ``width``."""
    if len(text) <= width:
        return text
    half = (width - 5) // 2
    return f"{text[:half]} ... {text[-half:]}"


def shown(value: object) -> str:
    """A value for a message, on one line: text in quotes, large arrays by their shape."""
    if isinstance(value, str):
        return shortened(repr(value))
    if isinstance(value, Rational):
        top, bottom = int(value.numerator), int(value.denominator)
        if max(abs(top), bottom) > LARGEST:
            size = math.log10(abs(top)) - math.log10(bottom)
            return f"about {'-' * (top < 0)}1e{math.floor(size):+d}"
    if isinstance(value, tuple) and len(value) == 2:
        return f"({', '.join(map(shown, value))})"
    kind = type(value).__name__
    try:
        if getattr(value, "size", 0) > 4 and hasattr(value, "shape"):
            return f"an array of shape {value.shape}"
        return shortened(" ".join(repr(value).split()))
    except NO_TEXT:
        return f"an object of type {kind}"


# --- Checks ---------------------------------------------------------------------------------------


def positive_integer(number: object) -> int:
    """The value of an integer of at least 1; 0 for anything else."""
    try:
        found = operator.index(number)  # type: ignore[arg-type]
    except TypeError:
        return 0
    return 0 if isinstance(number, bool) else max(0, found)


def checked_count(number: object, name: str, most: int | None = None) -> int:
    """An integer from 1 to ``most``, without a limit if that is None; ValueError otherwise."""
    found = positive_integer(number)
    if not found:
        raise ValueError(f"{name} must be an integer of at least 1, got {shown(number)}")
    if most is not None and found > most:
        raise ValueError(f"{name} must be an integer of at most {most}, got {shown(number)}")
    return found


def check_kind(name: str, value: object, kind: type) -> None:
    """Raise TypeError unless a value is of a type that has a public name."""
    if not isinstance(value, kind):
        raise TypeError(f"{name} must be {_imported(kind)}, got {shown(value)}")


def _imported(kind: type) -> str:
    """The name by which a caller imports a type, from the outermost package that has it."""
    parts = kind.__module__.split(".")
    packages = [".".join(parts[:depth]) for depth in range(1, len(parts) + 1)]
    found = next(p for p in packages if kind.__name__ in dir(sys.modules[p]))
    return f"{found}.{kind.__name__}"


def is_several(value: object) -> bool:
    """Whether a value is a collection of others: iterable, and neither text nor bytes."""
    return isinstance(value, Iterable) and not isinstance(value, str | bytes | bytearray)


def check_text(name: str, value: object) -> None:
    """Raise TypeError unless a value is text."""
    if not isinstance(value, str):
        raise TypeError(f"{name} must be text, got {shown(value)}")


def check_functions(**given: object) -> None:
    """Raise TypeError unless each named value is callable or None."""
    for name, value in given.items():
        if value is not None and not callable(value):
            raise TypeError(f"{name} must be a function, got {shown(value)}")


def check_mapping(name: str, values: object, such_as: str = "{'a': '5/4'}") -> None:
    """Raise TypeError unless values are given as a mapping."""
    if not isinstance(values, Mapping):
        raise TypeError(f"{name} must be a mapping such as {such_as}, got {shown(values)}")


def checked_number(name: str, value: object) -> float:
    """A real number as a float; TypeError if it is none, ValueError if it is too large."""
    if not isinstance(value, str | bytes | bytearray):  # of which float() would take the text
        try:
            return float(value)  # type: ignore[arg-type]
        except OverflowError:
            raise ValueError(f"{name} must fit into a double, got {shown(value)}") from None
        except (TypeError, ValueError):
            pass
    raise TypeError(f"{name} must be a number, got {shown(value)}")


def checked_pair(name: str, pair: object) -> tuple[float, float]:
    """Two real numbers as floats; TypeError if they are no pair of numbers."""
    if not isinstance(pair, tuple | list) or len(pair) != 2:
        raise TypeError(f"{name} must be two numbers, got {shown(pair)}")
    return checked_number(name, pair[0]), checked_number(name, pair[1])


def checked_path(path: str | os.PathLike[str]) -> Path:
    """The path of a file; TypeError for a value of any other type."""
    if not isinstance(path, str | os.PathLike):
        raise TypeError(f"the path of a file was expected, got {shown(path)}")
    return Path(path)


# --- Calls that do not fit ------------------------------------------------------------------------


def explained(instead: str = "") -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorate a function: if a call does not fit, TypeError tells what does, and ``instead``."""

    def around(verb: Callable[P, R]) -> Callable[P, R]:
        @wraps(verb)
        def call(*args: P.args, **named: P.kwargs) -> R:
            try:
                return verb(*args, **named)
            except TypeError as error:
                unfit = _misfit(verb, args, named, instead)
                if not unfit:  # the call fits: the function itself raised the error
                    raise
                raise TypeError(unfit) from error

        return call

    return around


def explained_fields(kind: type[C]) -> type[C]:
    """Apply :func:`explained` to the constructor of a class, such as a frozen dataclass."""
    made: Any = kind
    made.__init__ = explained()(made.__init__)
    return kind


def _misfit(
    verb: Callable[..., Any], args: tuple[Any, ...], named: Mapping[str, Any], instead: str
) -> str:
    """A sentence on why arguments do not fit a signature; empty if they do."""
    import inspect  # imported only for an error, so that programs start fast

    signature = inspect.signature(verb)
    try:
        signature.bind(*args, **named)
    except TypeError as error:
        reason = str(error)
    else:
        return ""
    known = list(signature.parameters.values())
    own = int(known[0].name in ("self", "cls"))  # self or cls, which no caller passes
    by_name = [each.name for each in known[own:] if each.kind is each.KEYWORD_ONLY]
    by_place = [each.name for each in known[own:] if each.name not in by_name]
    parts = [", ".join(by_place), f"by name {', '.join(by_name)}" if by_name else ""]
    name = verb.__qualname__.removesuffix(".__init__")
    takes = f"{name} takes {', and '.join(filter(None, parts))}"
    unknown = [f"{key}={shown(named[key])}" for key in named if key not in signature.parameters]
    if unknown:
        return f"{takes}, got {', '.join(unknown)}{'; ' * bool(instead)}{instead}"
    if len(args) - own > len(by_place):
        return f"{takes}, got {shown(args[own + len(by_place)])} by place"
    return f"{takes}: {reason}"
