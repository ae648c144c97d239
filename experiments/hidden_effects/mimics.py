"""How well named laws could pass for the hidden one: what nobody can see, nobody can be blamed for not seeing.

The device is simulated with the named laws in place of the hidden one, without noise, and everything that may be fitted
is: the linear part, the sizes of the laws and their shapes. What is left, in units of the noise, is what an observer
who knew both would have to tell them apart by.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares

from .generator import Case, Device, hidden_in, respond
from .laws import INDEX, LAWS

SEEN = 25.0  # χ²: five standard deviations, for an observer who knows what to compare
_SUBSTEPS = 2  # of the solver per sample, for all laws, so that their errors cancel
_MOST = 40  # steps of each search
_SIZES = (0.3, 1.0, 3.0)  # of the hidden law's coefficient, from which the searches start


def left_by(case: Case, names: Sequence[str]) -> float:
    """The least χ² that a device with the laws `names`, of the study's own kind or the textbook's, leaves of the fitted
    records without their noise."""
    measured = [(plan, made.sigma) for plan, made in zip(case.plans, case.records, strict=True) if not plan.holdout]
    c, s = hidden_in(case)
    largest = float(np.max(np.abs(c)))
    at = [INDEX[name] for name in names]

    def readings(device: Device, c: np.ndarray, s: np.ndarray) -> np.ndarray:
        """Of the fitted records, in units of their noise."""
        found = [respond(plan, device, c, s, _SUBSTEPS)[0] * device.unit / sigma for plan, sigma in measured]
        return np.nan_to_num(np.concatenate(found), nan=1e6, posinf=1e6, neginf=-1e6)

    true, least = readings(case.device, c, s), np.inf
    for own, start in itertools.product((False, True), _SIZES):
        shapes = np.zeros((len(LAWS), 3))
        for i in at:
            shapes[i] = LAWS[i].shape(np.random.default_rng(0), own)
        bent = np.nonzero(shapes)

        def misfit(x: np.ndarray, shapes: np.ndarray = shapes, bent: tuple[np.ndarray, ...] = bent) -> np.ndarray:
            device, c, s = _moved(case.device, x[:3]), np.zeros(len(LAWS)), shapes.copy()
            c[at] = largest * x[3 : 3 + len(at)]
            s[bent] *= np.exp(x[3 + len(at) :])
            return readings(device, c, s) - true

        first = np.concatenate([np.zeros(3), np.full(len(at), start), np.zeros(len(bent[0]))])
        found = least_squares(misfit, first, method="lm", diff_step=1e-4, max_nfev=_MOST * (len(first) + 1))
        least = min(least, 2 * float(found.cost))
    return least


def _moved(device: Device, by: np.ndarray) -> Device:
    """A device with frequency, quality and gain changed by these logarithms."""
    frequency, quality, gain = np.exp(by) * (device.frequency, device.quality, device.gain)
    return replace(device, frequency=frequency, quality=quality, gain=gain)
