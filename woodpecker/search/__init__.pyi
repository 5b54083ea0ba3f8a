"""The search for all branches of a map: from slices, along branches, to their ends."""

from .checkpoint import Record as Record
from .checkpoint import Seen as Seen
from .diagrams import Found as Found
from .explorer import Stage as Stage
from .search import Search as Search
from .tasks import BranchState as BranchState
