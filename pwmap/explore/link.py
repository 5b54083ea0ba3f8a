"""States of pages, each a frozen dataclass, and their fields as text in links and wishes."""

from __future__ import annotations

import json
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self, get_args, get_origin
from typing import get_type_hints as hints_of
from urllib.parse import parse_qsl, urlencode

from pwmap.diagrams.record import plain

if TYPE_CHECKING:
    from pwmap.diagrams.data import Branch

QUERY_MOST = 4000  # characters of a link
NAMES_MOST = 64  # names in a link
PREFIX = "at_"  # of the name of a parameter in a link


class LinkedState(ABC):
    """The state that all views of a page share."""

    __slots__ = ()
    SHORT: ClassVar[Mapping[str, str]] = {}  # by field, names in links that differ from its own
    BESIDE: ClassVar[tuple[str, ...]] = ()  # fields that links do not name

    @abstractmethod
    def query(self) -> str:
        """The link: all that differs from the state of an empty one, with all bits of numbers."""

    @abstractmethod
    def python(self) -> str:
        """Lines of Python that compute and draw what the page shows."""

    @property
    @abstractmethod
    def place(self) -> Mapping[str, Any]:
        """The value of each parameter, for JSON."""

    @property
    @abstractmethod
    def value(self) -> float:
        """The value of the diagram's parameter."""

    @property
    def ends(self) -> tuple[float, float]:
        """The interval of the diagram's parameter."""
        state: Any = self
        low, high = (float(Fraction(each)) for each in state.span)
        return low, high

    @abstractmethod
    def at(self, values: Mapping[str, Any]) -> Self:
        """The state with other values of parameters; ValueError if they are not valid."""

    @abstractmethod
    def at_sample(self, branch: Branch, sample: int) -> Self:
        """The state that shows a sample of a branch."""

    @abstractmethod
    def with_axis(self, name: str) -> Self:
        """The state with the diagram over another parameter; ValueError if it is unknown."""

    def json(self) -> str:
        """All fields, and the link."""
        state: Any = self
        return json.dumps({**plain(asdict(state)), "link": self.query()}, indent=1)

    @classmethod
    def names(cls) -> dict[str, str]:
        """The fields by their names in links."""
        kept: Any = cls
        plain = [each.name for each in fields(kept) if each.name not in cls.BESIDE]
        return {cls.SHORT.get(name, name): name for name in plain}

    @classmethod
    def is_parameter(cls, key: str) -> bool:
        """Whether a name in a link is that of a parameter."""
        return key.startswith(PREFIX)

    @classmethod
    def read(cls, name: str, text: str, called: str = "") -> Any:
        """Read a field from text by its type; ValueError names it, or what it is ``called``."""
        return _read(_hints(cls)[name], called or name, text)

    def told(self) -> dict[str, Any]:
        """The fields as a page shows them."""
        values = {name: getattr(self, name) for name in self.names().values()}
        return {k: ", ".join(map(str, v)) if isinstance(v, tuple) else v for k, v in values.items()}

    def link_from(self, first: Self, values: Sequence[tuple[str, str]]) -> str:
        """A link with values of parameters, and all fields that differ from those of ``first``."""
        changed = [
            (key, as_text(getattr(self, name)))
            for key, name in self.names().items() if getattr(self, name) != getattr(first, name)
        ]  # fmt: skip
        return urlencode([*values, *changed], safe=",/")

    @classmethod
    def parts_of(cls, query: str) -> tuple[dict[str, str], dict[str, Any]]:
        """Split a link into values of parameters as text, and fields; ValueError if it is wrong."""
        if len(query) > QUERY_MOST:
            raise ValueError(f"a link has at most {QUERY_MOST} characters, got {len(query)}")
        values, own, names = dict[str, str](), dict[str, Any](), cls.names()
        for key, text in parse_qsl(query, keep_blank_values=True, max_num_fields=NAMES_MOST):
            if cls.is_parameter(key):
                values[key.removeprefix(PREFIX)] = text
            elif key in names:
                own[names[key]] = cls.read(names[key], text)
            else:
                raise ValueError(f"unknown name in the link: {key[:40]!r}")
        return values, own


_hints = lru_cache(lambda cls: hints_of(cls, include_extras=True))


def _read(kind: Any, name: str, text: str) -> Any:
    if get_origin(kind) is tuple:
        each, *others = get_args(kind)
        parts = tuple(_read(each, name, part) for part in text.split(",") if part)
        if others != [...] and len(parts) != 1 + len(others):
            what = "numbers" if each is float else "rationals"
            raise ValueError(f"{name} must be two {what}, got {text[:40]!r}")
        return parts
    if get_origin(kind) is Annotated:  # text that a function of its own reads
        return kind.__metadata__[0](text)
    if kind is str:
        return text
    value = number(name, text)
    if kind is float:
        return value
    if value != int(value if math.isfinite(value) else 0.5):
        raise ValueError(f"{name} must be a whole number, got {text[:40]!r}")
    return kind(value)


def as_text(value: object) -> str:
    """A value as it stands in a link."""
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, tuple):
        return ",".join(map(as_text, value))
    return str(value) if isinstance(value, str) else repr(value)


def number(name: str, text: str) -> float:
    """A number from text; ValueError if it is none."""
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{name[:40]} must be a number, got {text[:40]!r}") from None


def numbers(values: object, names: Sequence[str]) -> dict[str, float]:
    """Numbers by known names, infinite ones too; ValueError names the first that is none or nan."""
    if not isinstance(values, dict):
        raise ValueError("values must be numbers by their names")
    for name, value in values.items():
        if name not in names:
            raise ValueError(f"unknown parameter {str(name)[:40]!r}, known are {', '.join(names)}")
        if isinstance(value, bool) or not isinstance(value, int | float) or value != value:
            raise ValueError(f"{name} must be a number, got {str(value)[:40]!r}")
    return {name: float(value) for name, value in values.items()}


def one_of(name: str, value: object, known: Sequence[object]) -> None:
    """ValueError unless a value is among the known ones."""
    if value not in known:
        raise ValueError(f"{name} must be one of {known}, got {value!r}")
