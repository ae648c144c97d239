"""The shape that a driven oscillator's response can have, whatever its physics, so that the rest is noise.

A response to a periodic drive is a Fourier series plus a transient. With the transient's own pole e^{(−α + iω)t} every
weak nonlinearity can only add products of the two: poles −jα + i(jω ± kω_drive), and slow changes of them.
No parameter of a model enters, so the noise floor does not depend on the model being right.

Source: A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations, 1979, ch. 4 (combination tones of weak nonlinearity).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dtrsm  # pyright: ignore[reportAttributeAccessIssue]  (missing from its stubs)

_LONG = 4096  # samples: of fewer a QR takes no time
_INDEPENDENT = 1e-5
"""Of its length, what a column must have beside those before it: the square is then far above rounding."""

FIRST = 600
"""Samples (8 per period) in which the transient is looked for: later it has died, or is as plain as before."""


@dataclass(frozen=True)
class Pole:
    """The transient: `rate` ω in rad per sample, `decay` α per sample."""

    rate: float
    decay: float


def harmonic_columns(n: int, drive_rate: float | None, count: int) -> np.ndarray:
    """(n, 1 + 2K) constant, cosines and sines of the drive's harmonics below the Nyquist frequency."""
    rows = [np.ones(n)]
    if drive_rate is not None:
        first = np.exp(1j * drive_rate * np.arange(n))
        power = np.ones(n, dtype=complex)
        for k in range(1, count + 1):
            if k * drive_rate >= np.pi * (1 - 1e-9):
                break
            power = power * first
            rows += [np.real(power), np.imag(power)]
    return np.array(rows).T


def transient_columns(n: int, drive_rate: float | None, pole: Pole, highest: int) -> tuple[np.ndarray, np.ndarray]:
    """(n, M) decaying columns of a transient and its products with the drive's response, (M,) the level of each.

    The columns of all levels up to `highest`, in the order of their levels: 1 is the transient itself, 2 its products
    of second order, 3 those of third order, and 4 all of these changing slowly, as an amplitude-dependent frequency
    makes them.
    """
    time = np.arange(n)
    powers = [np.ones(n)]
    for _ in range(7 if highest >= 4 else 3):
        powers.append(powers[-1] * (2.0 * time / n - 1.0))
    decays = [np.exp(-orders * pole.decay * time) for orders in range(4)]
    turning = [np.exp(1j * orders * pole.rate * time) for orders in range(4)]
    driven = [np.exp(1j * orders * (drive_rate or 0.0) * time) for orders in range(4)]
    rows: list[tuple[int, np.ndarray]] = []

    def add(own: int, drive: int, orders: int, levels: tuple[int, ...]) -> None:
        """A pole `own` × ω + `drive` × that of the drive, decay `orders` × α; its power j of time belongs to the level
        `levels[j]`."""
        if levels[0] > highest:
            return
        wave = turning[own] * (driven[drive] if drive >= 0 else driven[-drive].conj()) * decays[orders]
        turns = abs(own * pole.rate + drive * (drive_rate or 0.0)) > 1e-4
        for power, level in enumerate(levels):
            if level <= highest:
                rows.append((level, np.real(wave) * powers[power]))
                if turns:
                    rows.append((level, np.imag(wave) * powers[power]))

    add(1, 0, 1, (1, 2, 2, 3, 4, 4, 4, 4))
    add(0, 0, 2, (2, 2, 4, 4))
    add(2, 0, 2, (2, 2, 4, 4))
    add(3, 0, 3, (2, 4, 4))
    add(1, 0, 3, (2, 4, 4))
    add(0, 0, 1, (3, 4, 4))
    if drive_rate is not None:
        add(0, 1, 2, (2, 2, 4, 4))
        add(0, 2, 2, (3, 4, 4))
        for order in (1, -1):
            add(1, order, 1, (2, 2, 4, 4, 4, 4))
            add(2, order, 2, (2, 4, 4))
            add(1, 2 * order, 1, (2, 4, 4))
            add(1, 3 * order, 1, (3, 4, 4))
            add(2, 2 * order, 2, (3, 4, 4))
            add(3, order, 3, (3, 4, 4))
    rows.sort(key=lambda one: one[0])
    return np.array([row for _, row in rows]).T, np.array([level for level, _ in rows])


def orthonormal(columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, M) an orthonormal basis of the columns' span, and (N,) which of the N columns added to it.

    Long columns that are far enough from dependent: by the Cholesky factor of their products, which takes a quarter of
    the time of a QR and leaves them orthogonal to some 1e-6.
    Source: Y. Yamamoto et al., Electron. Trans. Numer. Anal. 44 (2015) 306.
    """
    norms = np.sqrt(np.einsum("ij,ij->j", columns, columns))
    columns = columns / np.where(norms > 0, norms, 1.0)
    plain = _by_cholesky(columns) if len(columns) >= _LONG else None
    if plain is not None:
        return plain, np.ones(columns.shape[1], dtype=bool)
    basis, triangle = np.linalg.qr(columns)
    kept = np.abs(np.diag(triangle)) > 1e-9
    return basis[:, kept], kept


def _by_cholesky(columns: np.ndarray) -> np.ndarray | None:
    """The basis, (n, M), of columns of length 1; None if they are too near to dependent for it."""
    try:
        factor = np.linalg.cholesky(columns.T @ columns)
    except np.linalg.LinAlgError:
        return None
    if np.min(np.diag(factor)) < _INDEPENDENT:
        return None
    return np.asarray(dtrsm(1.0, factor, columns, side=1, lower=1, trans_a=1))


def beside(basis: np.ndarray, signals: np.ndarray) -> np.ndarray:
    """(n, …) what signals have beside a basis (n, M): projected twice, for it is orthonormal to some 1e-6 only, and a
    noise may be less."""
    for _ in range(2):
        signals = signals - basis @ (basis.T @ signals)
    return signals


def _thinned(values: np.ndarray, block: int) -> np.ndarray:
    """Means over blocks of samples: an exponential stays an exponential."""
    whole = len(values) // block * block
    return values[:whole].reshape(-1, block).mean(axis=1)


def _peaks(values: np.ndarray) -> np.ndarray:
    """Rates (rad per sample) of the three largest lines that stand out of a spectrum, if any do."""
    size = 4 * len(values)
    spectrum = np.abs(np.fft.rfft(values * np.hanning(len(values)), size))[: int(0.45 * size)]
    peaks = np.flatnonzero((spectrum[1:-1] > spectrum[:-2]) & (spectrum[1:-1] >= spectrum[2:])) + 1
    peaks = peaks[(spectrum[peaks] > 4.0 * np.median(spectrum)) & (peaks > 6)]
    return 2 * np.pi * peaks[np.argsort(spectrum[peaks])[::-1][:3]] / size


def dies(values: np.ndarray, rate: float) -> bool:
    """Whether a line has lost more than half of itself from the first third to the last: mains hum stays."""
    beat = values * np.exp(-1j * rate * np.arange(len(values)))
    third = len(values) // 3
    return bool(abs(np.mean(beat[-third:])) < 0.5 * abs(np.mean(beat[:third])))


def find_transient(
    response: np.ndarray, drive_rate: float | None, count: int, avoid: Sequence[tuple[float, float]] = ()
) -> Pole | None:
    """The pole of the transient by separable least squares; None if there is no transient to be seen.

    **Arguments:** `response` (n,), `drive_rate`: rad per sample or None, `count`: harmonics of the drive, `avoid`:
    lowest and highest rates of lines that are no transient unless they die (mains hum).
    """
    rates = _lines(response, drive_rate, count, avoid)
    if not rates:
        return None
    block = max(1, int(2 * np.pi / max(*rates, drive_rate or 0.0) / 8))
    thin = _thinned(response, block)[:FIRST]
    thin_rate = None if drive_rate is None else drive_rate * block
    length = len(thin)
    harmonics, _ = orthonormal(harmonic_columns(length, thin_rate, min(count, 6)))
    thin = thin - harmonics @ (harmonics.T @ thin)

    def misfit(parameters: np.ndarray, level: int) -> np.ndarray:
        pole = Pole(float(parameters[0]), float(np.exp(parameters[1])))
        columns, _ = transient_columns(length, thin_rate, pole, level)
        columns = columns - harmonics @ (harmonics.T @ columns)
        basis = np.linalg.qr(columns / np.linalg.norm(columns, axis=0).clip(1e-300))[0]
        return thin - basis @ (basis.T @ thin)

    best = _nearest(misfit, [rate * block for rate in rates], length)
    return Pole(float(best[0]) / block, float(np.exp(best[1])) / block)


def _lines(
    response: np.ndarray, drive_rate: float | None, count: int, avoid: Sequence[tuple[float, float]]
) -> list[float]:
    """Rates (rad per sample) of the lines that stand out beside the drive's harmonics, in the whole or at its
    beginning; without those to `avoid` that stay."""
    n = len(response)
    rest = beside(orthonormal(harmonic_columns(n, drive_rate, count))[0], response)
    rates = np.concatenate([_peaks(rest), _peaks(rest[: max(n // 4, 64)])])
    return [
        float(rate) for rate in rates
        if not any(low - 7.0 / n < rate < high + 7.0 / n for low, high in avoid) or dies(rest, rate)
    ]  # fmt: skip


def _nearest(misfit: Callable[[np.ndarray, int], np.ndarray], rates: list[float], length: int) -> np.ndarray:
    """Rate and ln of the decay, per sample, of least misfit: from the best of some starts, first with the transient's
    own columns, then with those of its products."""
    starts = [np.array([rate, np.log(decay / length)]) for rate in rates for decay in (2.0, 8.0)]
    costs = [float(np.sum(misfit(start, 1) ** 2)) for start in starts]
    best = starts[int(np.argmin(costs))]
    low, high = np.array([1e-3, np.log(0.1 / length)]), np.array([np.inf, np.log(100.0 / length)])
    scale = np.array([1.0 / length, 0.3])
    for level, steps in ((1, 3), (2, 5)):
        best = np.clip(best, low, high)
        best = _minimised(lambda point, level=level: misfit(point, level), best, scale, low, high, steps)
    return best


def _minimised(
    misfit: Callable[[np.ndarray], np.ndarray],
    start: np.ndarray,
    scale: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    steps: int,
) -> np.ndarray:
    """Levenberg-Marquardt with difference quotients, a few steps: the pole need not be exact."""
    point, here, damping = start, misfit(start), 0.1
    for _ in range(steps):
        moves = [np.where(np.arange(len(scale)) == j, 1e-3 * scale, 0.0) for j in range(len(scale))]
        slopes = np.column_stack([(misfit(point + move) - here) / 1e-3 for move in moves])
        normal, gradient = slopes.T @ slopes, slopes.T @ here
        normal[np.diag_indices_from(normal)] *= 1.0 + damping
        step = np.clip(np.linalg.lstsq(normal, -gradient, rcond=None)[0], -3.0, 3.0)
        trial = np.clip(point + step * scale, low, high)
        there = misfit(trial)
        gain = float(np.sum(here**2) - np.sum(there**2))
        if gain > 0:
            small = gain < 1e-2 * float(np.sum(here**2))
            point, here, damping = trial, there, damping * 0.2
            if small:
                break
        else:
            damping *= 10.0
    return point
