"""Solving the equation of motion for the measured drive."""

from .ensemble import respond_many as respond_many
from .lane import ALLOWED as ALLOWED
from .substeps import divided as divided
from .substeps import lay_out as lay_out
from .substeps import lay_path as lay_path
from .substeps import steps_of as steps_of
from .system import Equation as Equation
from .system import at_rest as at_rest
from .tape import Tape as Tape
from .transient import Response as Response
from .transient import respond as respond
