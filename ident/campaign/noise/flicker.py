"""Flicker noise beside white: what amplifiers and sensors have more of the lower the frequency, without an end.

Where the lowest frequencies cannot be seen, an autoregression of one or two coefficients levels off below those that
can, and missed two fifths of a noise whose power goes as 1/f.

Source: M. S. Keshner, 1/f noise, 1982, Proc. IEEE 70, 212 (power as 1/f over as many decades as were measured);
P. Whittle, 1953, Ark. Mat. 2, 423 (the likelihood).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from .autoregression import FLICKER_ORDER, ORDER_PRICE, Autoregression, ar_spectrum, autocovariance, levinson

_NEAREST = 8.0  # of the logit of the share of flicker noise: beyond, it is one of the two alone


def or_flicker(fit: Autoregression, samples: np.ndarray) -> Autoregression:
    """A noise that was fitted to the frequencies `fit.used` of some samples (n,), or in its place one of the power
    S(f) = σ² (1 − q + q g(f)), g ∝ 1/f of mean one, where that describes these frequencies better.

    The share q and σ are two numbers; an autoregression has one and its order, each at the same price. What is returned
    has the autoregressive coefficients that predict such a noise best.
    """
    n, used = len(samples), fit.used
    power = np.abs(np.fft.rfft(samples)) ** 2 / n
    below = 1.0 / np.maximum(np.arange(len(power)), 1.0)
    below /= autocovariance(below, 0, n)[0]
    kept = used > 0
    weight, seen, slope = used[kept], power[kept], below[kept] - 1.0

    def deviance(logit: float) -> float:
        shape = 1.0 + _share(logit) * slope
        level = weight @ (seen / shape) / weight.sum()
        return 2.0 * float(weight @ (np.log(level * shape) + seen / (level * shape)))

    found: Any = minimize_scalar(deviance, bounds=(-_NEAREST, _NEAREST), method="bounded")
    own = 2.0 * float(weight @ (np.log(fit.spectrum[kept]) + seen / fit.spectrum[kept]))
    price = ORDER_PRICE * np.log(2.0 * weight.sum())
    if float(found.fun) + price >= own + price * len(fit.ar):
        return fit
    share = _share(float(found.x))
    shape = 1.0 + share * slope
    variance = float(weight @ (seen / shape) / weight.sum())
    spectrum = variance * (1.0 + share * (below - 1.0))
    ar, innovation = levinson(autocovariance(spectrum, FLICKER_ORDER, n), FLICKER_ORDER)
    by_numbers = np.stack([np.ones(len(slope)), slope / shape])  # of the log power, by those of σ² and by the share
    information = (by_numbers * weight) @ by_numbers.T
    error = 0.5 * float(np.sqrt(np.linalg.inv(information)[0, 0]))
    return replace(fit, sigma=variance**0.5, ar=tuple(float(a) for a in ar), relative_error=min(error, 1.0),
                   spectrum=ar_spectrum(ar, innovation, n))  # fmt: skip


def _share(logit: float) -> float:
    return 1.0 / (1.0 + float(np.exp(-logit)))
