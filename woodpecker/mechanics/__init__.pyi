"""The toy: its data, its equations of motion, and what is known in closed form."""

from .equations import Equilibrium as Equilibrium
from .equations import energy as energy
from .equations import equilibrium as equilibrium
from .equations import free_frequency as free_frequency
from .equations import jam_limit as jam_limit
from .toy import ExpansionFriction as ExpansionFriction
from .toy import Toy as Toy
from .toy import parameters as parameters
