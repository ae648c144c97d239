"""Least squares: starting values, the solver, uncertainties, identifiability, and the Fit."""

from .fit import Fit as Fit
from .fit import fit as fit
