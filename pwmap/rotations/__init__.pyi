"""Cycles by their words: rotations, tongues, families, and where they begin."""

from .centres import CentreKind as CentreKind
from .centres import OrganisingCentre as OrganisingCentre
from .centres import organising_centre as organising_centre
from .centres import organising_centres as organising_centres
from .families import FamilyCondition as FamilyCondition
from .families import FamilyCycle as FamilyCycle
from .families import WordFamily as WordFamily
from .families import word_family as word_family
from .numbers import RotationInterval as RotationInterval
from .numbers import RotationNumber as RotationNumber
from .numbers import rotation_interval as rotation_interval
from .numbers import rotation_number_at as rotation_number_at
from .tongues import Tongue as Tongue
from .tongues import tongues as tongues
from .words import farey as farey
from .words import rotation_number as rotation_number
from .words import rotational_word as rotational_word
