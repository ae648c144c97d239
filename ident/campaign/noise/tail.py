"""What a motion adds to noise above the frequencies that drive it: a tail, steeper than any noise.

Beside noise of the power S(k) a record shows a S(k) + c k^−m. A first-order filter, and a walk at random, make noise
fall as k⁻² at most; a displacement answers a push that is white with k⁻⁴, a smooth push dies faster. Without a tail a
colour that rises towards low frequencies takes up its foot, and the noise that it tells is the more the farther it is
extrapolated below: white floors were 1.2 to 1.8 times too high, some four times (`experiments.free_floors`).

Source: P. Whittle, 1953, Ark. Mat. 2, 423 (the likelihood); C. Févotte, N. Bertin, J.-L. Durrieu, Neural Comput. 21
(2009) 793 (the powers of a sum, by updates that are factors); G. Schwarz, Ann. Stat. 6 (1978) 461 (the price); C. R.
Rao, Proc. Camb. Phil. Soc. 44 (1948) 50 (what a little of a tail gains).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

_STEEPNESS = (4, 8, 16)  # m: of a displacement under a push that is white, and twice and four times as steep
_NUMBERS = 2  # that tell a tail: its size and its steepness
_ROUNDS = 60  # of the updates, at most
_STILL = 1e-3  # relative: both sizes have been found


class Beside(NamedTuple):
    """Noise beside a tail: −2 log likelihood with the price of the tail's numbers; how much of the noise there is, in
    power, and the relative error of that; and the power (n,) of both together."""

    deviance: float
    level: float
    error: float
    expected: np.ndarray


def beside_a_tail(power: np.ndarray, noise: np.ndarray, place: np.ndarray, price: float) -> Beside:
    """What the power (n,) of a record at some frequencies is as noise of a colour, `noise` (n,), and the tail of a
    motion where that pays for its numbers, `price` each, and ends: a noise below it everywhere is not seen.

    **Arguments:** `place` (n,): the frequencies over the lowest of them.
    """
    alone = float(np.mean(power / noise))
    flat = alone * noise
    best = Beside(deviance_of(power, flat), alone, len(power) ** -0.5, flat)
    for steepness in _STEEPNESS:
        shape = noise[0] * place**-steepness
        slope = shape / flat
        score = float(slope @ (power / flat - 1.0))
        if score <= 0.0 or score**2 < _NUMBERS * price * float(slope @ slope):
            continue
        shapes = np.stack([noise, shape])
        sizes = _sizes(power, shapes, alone)
        expected = sizes @ shapes
        deviance = deviance_of(power, expected) + _NUMBERS * price
        if deviance < best.deviance and sizes[1] * shape[-1] < sizes[0] * noise[-1]:
            shares = sizes[:, None] * shapes / expected
            error = float(np.sqrt(np.linalg.pinv(shares @ shares.T)[0, 0]))
            best = Beside(deviance, float(sizes[0]), error, expected)
    return best


def deviance_of(power: np.ndarray, expected: np.ndarray) -> float:
    """−2 log likelihood of the power (n,) of a periodogram where so much is expected."""
    return 2.0 * float(np.sum(np.log(expected) + power / expected))


def _sizes(power: np.ndarray, shapes: np.ndarray, level: float) -> np.ndarray:
    """(2,) most likely sizes of the two shapes (2, n) of which the power (n,) is the sum, from `level` of each."""
    sizes = np.full(2, level)
    for _ in range(_ROUNDS):
        expected = sizes @ shapes
        factors = ((shapes / expected**2) @ power) / (shapes / expected).sum(axis=1)
        sizes = sizes * factors
        if np.max(np.abs(factors - 1.0)) < _STILL:
            break
    return sizes
