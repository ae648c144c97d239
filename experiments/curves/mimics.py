"""How well a named law could pass for the hidden one on a case's curves: what nobody can see, nobody can be blamed for.

The device is swept again with the named law in place of the hidden one, without noise, and everything that may be
fitted is: the linear part, the size of the law, of either sign, and its shapes, from some that the study draws and from
the textbook's; one that is drawn of either sign may pass through zero. What is left, in units of the noise, is what an
observer who knew both would have to tell them apart by. Every other frequency on the way up stands for itself, its
neighbour and the way down. All by the study's own simulators; the tool that is judged has no part in it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from experiments.hidden_effects.laws import INDEX, LAWS
from experiments.hidden_effects.mimics import SEEN as SEEN  # χ² from which on two laws are told apart

from .generator import LEVELS, Case, coefficient
from .orbits import remembers, settled_sweep
from .sweeps import READ, sweep

_DWELL = 2.2  # times the quality, in periods: settled to a part in a thousand, both laws alike
_EVERY = 2  # of the frequencies
_DRAWN = 2  # shapes of the law from which searches start, and the textbook's
_TOLD = 20  # draws that tell which numbers of a shape have either sign
_FEW, _MOST = 6, 40  # steps of each search, and of the best one
_FAR = 1e3  # noise floors: more than that says nothing of how far a motion without bound is


def left_by(case: Case, name: str, phase: bool) -> float:
    """The least χ² that a device with the law `name`, of the study's own kind, leaves of the curves of a case without
    their noise; `phase`: whether phases were recorded."""
    device, truth, i = case.device, case.truth, INDEX[name]
    hidden: Mapping[str, Any] = truth["laws"]  # type: ignore[assignment]
    floor, relative, turn = (float(truth[key]) for key in ("sigma", "relative", "phase"))  # type: ignore[arg-type]
    periods = int(np.ceil(_DWELL * device.quality)) + READ
    ratios = [curve.frequency[::_EVERY] / device.frequency for curve in case.curves if curve.up]

    true_c, true_s = np.zeros(len(LAWS)), np.zeros((len(LAWS), 3))
    for law, told in hidden.items():
        true_c[INDEX[law]], true_s[INDEX[law]] = told["coefficient"], told["shape"]
    named = np.zeros(len(LAWS))
    named[i] = 1.0
    one = sweep if remembers(true_c + named) else settled_sweep

    def swept(linear: np.ndarray, c: np.ndarray, s: np.ndarray) -> np.ndarray:
        """All levels, with the frequency, the quality and the gain changed by these logarithms."""
        higher, quality, gain = np.exp(linear) * (1.0, device.quality, device.gain)
        runs = zip(LEVELS, ratios, strict=True)
        return np.concatenate([one(r / higher, u, periods, gain, quality, c, s, device.geometry) for u, r in runs])

    true = swept(np.zeros(3), true_c, true_s)
    weight = np.sqrt(2 * _EVERY) * np.abs(true)
    along, across = (weight / np.hypot(floor / device.unit, by * np.abs(true)) for by in (relative, turn))

    shapes = lambda count, own: np.array([LAWS[i].shape(np.random.default_rng(k), own) for k in range(count)])
    drawn = shapes(_TOLD, True)
    either, scale = (np.min(drawn, 0) < 0) & (np.max(drawn, 0) > 0), np.max(np.abs(drawn), 0)

    def search_from(x: np.ndarray, shape: np.ndarray, most: int) -> tuple[float, np.ndarray]:
        """χ² and where it is: logarithms of frequency, quality and gain, the size, and changes of the shapes."""
        bent = np.flatnonzero((shape != 0) | either)

        def off(x: np.ndarray) -> np.ndarray:
            """In units of the noise."""
            c, s = np.zeros(len(LAWS)), np.zeros((len(LAWS), 3))
            c[i], s[i] = x[3], shape
            s[i, bent] = np.where(either[bent], shape[bent] + scale[bent] * x[4:], shape[bent] * np.exp(x[4:]))
            ratio = np.nan_to_num(swept(x[:3], c, s) / true, nan=_FAR, posinf=_FAR, neginf=-_FAR)
            turned = np.angle(ratio) * across if phase else np.zeros(0)
            return np.clip(np.concatenate([(np.abs(ratio) - 1) * along, turned]), -_FAR, _FAR)

        x = np.concatenate([x[:4], x[4:] if len(x) > 4 else np.zeros(len(bent))])
        found = least_squares(off, x, method="lm", diff_step=1e-3, max_nfev=most * (len(x) + 1))
        return 2 * float(found.cost), found.x

    ends, largest = [], max(told["size"] for told in hidden.values())
    for shape in np.unique(np.concatenate([shapes(1, False), drawn[:_DRAWN]]), axis=0):
        s = np.zeros((len(LAWS), 3))
        s[i] = shape
        size = coefficient(device, name, s, largest)[0]
        for sign in (1.0, -1.0):
            ends.append((*search_from(np.array([0, 0, 0, sign * size]), shape, _FEW), shape))
            if ends[-1][0] < SEEN:
                return ends[-1][0]
    least, x, shape = min(ends, key=lambda end: end[0])
    return min(least, search_from(x, shape, _MOST)[0])
