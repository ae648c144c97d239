"""The noise in the band of a drive, from what a model leaves below and above it: between two sides that are seen
nothing needs to be extrapolated.

The response shows noise above that band alone, as below it the stage follows whatever leaks from the drive. In what a
model leaves there is no such motion. Most of what it lacks shows in the band itself, which is not asked; but the
mean that an even law makes lies below, and such a floor says itself that it is not known.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .autoregression import Autoregression, fit_autoregression
from .flicker import or_flicker
from .floor import exciting, latest, windowed

_BELOW = 0.8  # of the lowest frequency of the drive: as far as is asked
_EDGE = 0.001  # of the drive's power, which is left beneath that
_LEAST = 20  # frequencies below, in which an order can be told
_NEAR = 3.0  # half-power widths around the resonance, which rings in what a model leaves
_WIDER = 2.0
"""Times: set on 120 floors beneath sweeps that were 1.4 to 2.1 times as far off as the fit itself claimed; on others
this claims 1.0 to 1.3 times as much (`experiments.hidden_noise`)."""


def interpolated(
    drive: np.ndarray, left: np.ndarray, unseen: float, resonance: float, width: float
) -> Autoregression | None:
    """The noise in what a model leaves of a record; None if nothing is free below the drive.

    **Arguments:** `drive` (n,) V and what is `left` (n,) m of the response; `unseen`: share of the frequencies up to
    which these are not free; `resonance` and its `width`, in cycles per sample.
    """
    drive, left = latest(drive), latest(left)
    power = exciting(drive)
    count = len(power)
    bottom = int(_BELOW * np.searchsorted(power, _EDGE * power[-1]))
    if bottom < _LEAST:
        return None
    frequency = np.arange(count) / len(drive)
    hidden = np.abs(frequency - resonance) < _NEAR * width
    hidden[bottom : int(unseen * count)] = True
    if np.count_nonzero(~hidden) < _LEAST:
        return None
    seen = windowed(left)
    found = or_flicker(fit_autoregression(seen, None, excluded=hidden), seen)
    return replace(found, relative_error=min(1.0, _WIDER * found.relative_error))
