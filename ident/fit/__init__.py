"""Least squares: starting values, the solver, uncertainties, identifiability, and the Fit."""

import sys
from types import ModuleType
from typing import Any

from .fit import Fit as Fit
from .fit import fit as fit
from .fit_data import fit_data as fit_data


class _Station(ModuleType):
    """The station may be called by its name: `ident.fit(data)`."""

    def __call__(self, *data: Any, **options: Any) -> Fit:
        return fit_data(*data, **options)


sys.modules[__name__].__class__ = _Station
