"""A drive that is smooth between its samples: what a filter in front of a converter lets through.

Such a signal has nothing above half the sampling rate, and its samples say all of it. A cubic spline through them is
low between the samples: of a sine of a third of the sampling rate by 6 %, of one of two fifths by 17 %. One of the
fifteenth degree is low by 0.001 and 0.15 %, and is still a curve of its surroundings (of the ninth, 1.7 % of two fifths
were a second mode of a scanner mirror). Where the record ends it is taken to go on as the samples there foretell: a
spline of a high degree without any beyond swings.

Sources: M. Unser, Sampling – 50 years after Shannon, Proc. IEEE 88 (2000) 569, doi:10.1109/5.843002, §IV (cardinal
splines tend to the sinc with their degree); S. M. Kay, S. L. Marple, Spectrum analysis – a modern perspective, Proc.
IEEE 69 (1981) 1380, doi:10.1109/PROC.1981.12184, §II-E (linear prediction by Burg's method, which is stable).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

_DEGREE = 15
_BEYOND = 80  # samples foretold: what they end with is 10⁻¹⁰ of itself where the record ends
_ORDER, _FROM = 16, 120  # of the prediction, and samples that it is made from: sines of 4 to 100 samples a period are
# met to 2e-5 of their amplitude in the first intervals, noise up to three tenths of the sampling rate to 1e-3


def smooth_drive(samples: np.ndarray) -> BSpline:
    """The curve through a drive (n,), a function of the place in samples, from 0 to n − 1."""
    from scipy.interpolate import make_interp_spline  # here, because its import costs more than reading a campaign

    before, after = _going_on(samples[::-1])[::-1], _going_on(samples)
    at = np.arange(-len(before), len(samples) + len(after), dtype=float)
    return make_interp_spline(at, np.concatenate([before, samples, after]), k=_DEGREE)


def _going_on(samples: np.ndarray) -> np.ndarray:
    """How a signal (n,) goes on after its end, as far as its last samples tell: (`_BEYOND`,)."""
    last = samples[-_FROM:].astype(float)
    forward, backward, filtered = last[1:], last[:-1], np.ones(1)
    for _ in range(min(_ORDER, max((len(last) - 1) // 3, 1))):
        power = float(forward @ forward + backward @ backward)
        if power <= 0:  # what comes is known exactly
            break
        reflected = -2.0 * float(forward @ backward) / power
        longer = np.append(filtered, 0.0)
        filtered = longer + reflected * longer[::-1]
        forward, backward = (forward + reflected * backward)[1:], (backward + reflected * forward)[:-1]
    weights, known = -filtered[:0:-1], last[len(last) - len(filtered) + 1 :]
    for _ in range(_BEYOND):
        known = np.append(known, weights @ known[len(known) - len(weights) :])
    return known[len(weights) :]
