"""Diagrams as data, with their queries, graphs, tables and files."""

from .data import Hit as Hit
from .data import StableInterval as StableInterval
from .data import Stretch as Stretch
