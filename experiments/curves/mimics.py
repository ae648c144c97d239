"""How well a named law could pass for the hidden one on a case's curves: what nobody can see, nobody can be blamed for.

The device is swept again with the named law in place of the hidden one, without noise, and everything that may be
fitted is: the linear part, the size of the law, of either sign, and its shapes. What is left, in units of the noise, is
what an observer who knew both would have to tell them apart by. Every other frequency on the way up stands for itself,
its neighbour and the way down. All by `sweeps`; the tool that is judged has no part in it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from experiments.hidden_effects.laws import INDEX, LAWS
from experiments.hidden_effects.mimics import SEEN as SEEN  # χ² from which on two laws are told apart

from .generator import LEVELS, Case, coefficient
from .sweeps import READ, sweep

_DWELL = 2.2  # times the quality, in periods: settled to a part in a thousand, both laws alike
_EVERY = 2  # of the frequencies
_MOST = 15  # steps of each search
_FAR = 1e3  # noise floors: more than that says nothing of how far a motion without bound is


def left_by(case: Case, name: str, phase: bool) -> float:
    """The least χ² that a device with the law `name`, of the study's own kind, leaves of the curves of a case without
    their noise; `phase`: whether phases were recorded."""
    device, truth, i = case.device, case.truth, INDEX[name]
    hidden: Mapping[str, Any] = truth["laws"]  # type: ignore[assignment]
    floor, relative, turn = (float(truth[key]) for key in ("sigma", "relative", "phase"))  # type: ignore[arg-type]
    periods = int(np.ceil(_DWELL * device.quality)) + READ
    ratios = [curve.frequency[::_EVERY] / device.frequency for curve in case.curves if curve.up]

    def swept(linear: np.ndarray, c: np.ndarray, s: np.ndarray) -> np.ndarray:
        """All levels, with the frequency, the quality and the gain changed by these logarithms."""
        higher, quality, gain = np.exp(linear) * (1.0, device.quality, device.gain)
        runs = zip(LEVELS, ratios, strict=True)
        return np.concatenate([sweep(r / higher, u, periods, gain, quality, c, s, device.geometry) for u, r in runs])

    true_c, true_s = np.zeros(len(LAWS)), np.zeros((len(LAWS), 3))
    for law, told in hidden.items():
        true_c[INDEX[law]], true_s[INDEX[law]] = told["coefficient"], told["shape"]
    true = swept(np.zeros(3), true_c, true_s)
    weight = np.sqrt(2 * _EVERY) * np.abs(true)
    along, across = (weight / np.hypot(floor / device.unit, by * np.abs(true)) for by in (relative, turn))

    s = np.zeros((len(LAWS), 3))
    s[i] = LAWS[i].shape(np.random.default_rng(0), True)
    size, bent = coefficient(device, name, s, max(told["size"] for told in hidden.values()))[0], np.nonzero(s[i])[0]

    def off(x: np.ndarray) -> np.ndarray:
        """In units of the noise."""
        c, shapes = np.zeros(len(LAWS)), s.copy()
        c[i] = size * x[3]
        shapes[i, bent] *= np.exp(x[4:])
        ratio = np.nan_to_num(swept(x[:3], c, shapes) / true, nan=_FAR, posinf=_FAR, neginf=-_FAR)
        turned = np.angle(ratio) * across if phase else np.zeros(0)
        return np.clip(np.concatenate([(np.abs(ratio) - 1) * along, turned]), -_FAR, _FAR)

    least = np.inf
    for sign in (1.0, -1.0):
        begin = np.concatenate([np.zeros(3), [sign], np.zeros(len(bent))])
        found = least_squares(off, begin, method="lm", diff_step=1e-3, max_nfev=_MOST * (len(begin) + 1))
        least = min(least, 2 * float(found.cost))
    return least
