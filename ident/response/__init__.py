"""Solving the equation of motion for the measured drive."""

from .groups import Group as Group
from .groups import make_groups as make_groups
from .transient import Equation as Equation
from .transient import simulate as simulate
from .transient import simulate_group as simulate_group
