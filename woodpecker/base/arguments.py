"""Calls whose arguments do not fit: one sentence that names them and what was expected."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from woodpecker.base.shown import shown

P = ParamSpec("P")
R = TypeVar("R")
C = TypeVar("C")


def explained(instead: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """A verb whose TypeError says what it takes, what it got, and how that is asked for instead."""

    def around(verb: Callable[P, R]) -> Callable[P, R]:
        @wraps(verb)
        def call(*args: P.args, **named: P.kwargs) -> R:
            try:
                return verb(*args, **named)
            except TypeError as error:
                unfit = _misfit(verb, args, named, instead)
                if not unfit:  # the call fits: the error is one of the verb, with its own sentence
                    raise
                raise TypeError(unfit) from error

        return call

    return around


def explained_fields(kind: type[C]) -> type[C]:
    """The same for what is made from named values, such as a frozen dataclass."""
    made: Any = kind
    made.__init__ = explained("")(made.__init__)
    return kind


def _misfit(
    verb: Callable[..., Any], args: tuple[Any, ...], named: Mapping[str, Any], instead: str
) -> str:
    """Why arguments do not fit a signature; nothing if they do."""
    import inspect  # only when something is wrong: no start waits for it

    signature = inspect.signature(verb)
    try:
        signature.bind(*args, **named)
    except TypeError as error:
        reason = str(error)
    else:
        return ""
    name = verb.__qualname__.removesuffix(".__init__")
    made = int(name != verb.__qualname__)  # then the first argument is what is being made
    known = list(signature.parameters.values())[made:]
    by_name = [each.name for each in known if each.kind is each.KEYWORD_ONLY]
    by_place = [each.name for each in known if each.name not in by_name]
    parts = [", ".join(by_place), f"by name {', '.join(by_name)}" if by_name else ""]
    takes = f"{name} takes {', and '.join(filter(None, parts))}"
    unknown = [f"{key}={shown(named[key])}" for key in named if key not in signature.parameters]
    if unknown:
        return f"{takes}, got {', '.join(unknown)}{'; ' * bool(instead)}{instead}"
    if len(args) - made > len(by_place):
        return f"{takes}, got {shown(args[made + len(by_place)])} by place"
    return f"{takes}: {reason}"
