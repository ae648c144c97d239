"""The noise of an amplitude-frequency curve, from how far each point leaves the curve through its neighbours.

Not the amplitude is interpolated but the dynamic stiffness 1/H (without phase: 1/a²), which a linear resonance makes a
polynomial of the frequency, so that the peak is not taken for noise; jumps cut a run in two.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import nnls

from .jump import find_jump
from .record import NoiseFloor, Sweep

_BESIDE = (-2, -1, 1, 2)
_CLIP = 3.0  # standard deviations beyond which a residual counts no more: the rest of a corner, an outlier
_KEPT = 0.99402  # E[min(x², 9)] of a standard normal x, by which clipping is undone
_FAINT = 8.0  # standard deviations below which 1/a is no longer linear in the noise: there the amplitude itself serves


@dataclass(frozen=True)
class _Scatter:
    """Squared residuals, and how much of σ², r² and σ_φ² each has: E[squared] = share @ (σ², r², σ_φ²)."""

    squared: np.ndarray
    share: np.ndarray


def sweep_noise(sweep: Sweep) -> Sweep:
    """The sweep with the noise that its points show: a constant and a relative part, and that of the phase.

    The variances of the residuals are linear in (σ², r², σ_φ²), found by the likelihood of Gaussian residuals.
    Where the points show no scatter, or are too few, that is said in `noise.method` and 1 % is assumed.
    """
    scatter = _scatter(sweep, np.zeros(len(sweep.frequency)))
    size = float(np.sqrt(np.mean(sweep.amplitude**2)))
    if scatter is None or len(scatter.squared) < 8:
        method = "assumed: 1 % of the rms amplitude (too few points to tell)"
        floor = NoiseFloor(0.01 * size, method=method, relative_error=1.0)
        return replace(sweep, noise=floor, relative_noise=0.0, phase_noise=0.01)
    for _ in range(3):
        variances, errors = _variances(scatter)
        found = _noisy(sweep, variances)
        scatter = _scatter(sweep, found.deviation) or scatter
    return _said(found, variances, errors, len(scatter.squared), size)


def _noisy(sweep: Sweep, variances: np.ndarray) -> Sweep:
    sigma, relative, phase = (float(x) for x in np.sqrt(variances))
    return replace(sweep, noise=NoiseFloor(sigma), relative_noise=relative, phase_noise=phase)


def _said(sweep: Sweep, variances: np.ndarray, errors: np.ndarray, count: int, size: float) -> Sweep:
    """The sweep with its noise in words, and the resolution of the table as the least floor."""
    typical = float(np.median(sweep.deviation))
    if typical < 1e-6 * size:
        method = "assumed: 0.1 % of the rms amplitude (the points show no scatter)"
        floor = NoiseFloor(1e-3 * size, method=method, relative_error=1.0)
        return replace(sweep, noise=floor, relative_noise=0.0, phase_noise=max(sweep.phase_noise, 1e-4))
    steps = np.diff(np.unique(sweep.amplitude))
    least = max(float(np.min(steps)) / np.sqrt(12.0) if len(steps) else 0.0, 1e-3 * typical)
    total = float(np.median(sweep.amplitude))
    share = np.array([1.0, total**2, 0.0])
    error = 0.5 * float(np.sqrt(share @ errors @ share)) / max(float(share @ variances), 1e-300)
    parts = [f"{sweep.relative_noise:.2g} of the amplitude"] if sweep.relative_noise else []
    parts += [f"{np.degrees(sweep.phase_noise):.2g}° of phase"] if sweep.phase is not None else []
    method = f"scatter of {count} points about their neighbours" + (f"; and {', '.join(parts)}" if parts else "")
    return replace(sweep, noise=NoiseFloor(max(sweep.noise.sigma, least), (), method, max(error, 0.05)))


def _scatter(sweep: Sweep, deviation: np.ndarray) -> _Scatter | None:
    found = [_of_piece(sweep, piece, deviation) for piece in _pieces(sweep)]
    found = [one for one in found if one is not None]
    if not found:
        return None
    return _Scatter(np.concatenate([s.squared for s in found]), np.concatenate([s.share for s in found]))


def _pieces(sweep: Sweep) -> list[np.ndarray]:
    """The rows of each run in the order of rising frequency, cut at its jump."""
    found = []
    for run in sweep.runs:
        rows = run.rows if run.up else run.rows[::-1]
        rows = rows[sweep.amplitude[rows] > 0]
        jump = find_jump(
            sweep.frequency[rows], sweep.amplitude[rows], None if sweep.phase is None else sweep.phase[rows]
        )
        found += np.split(rows, [jump.after]) if jump is not None else [rows]
    return [rows for rows in found if len(rows) >= len(_BESIDE) + 1]


def _of_piece(sweep: Sweep, rows: np.ndarray, deviation: np.ndarray) -> _Scatter | None:
    """Residuals of each inner point against the cubic through two neighbours on either side."""
    f, a = sweep.frequency[rows], sweep.amplitude[rows]
    centre = np.arange(2, len(rows) - 2)
    beside = centre[:, None] + np.array(_BESIDE)
    x = (f[beside] - f[centre][:, None]) / max(float(np.median(np.diff(f))), 1e-300)
    powers = x[:, None, :] ** np.arange(4)[None, :, None]
    weights = np.linalg.pinv(powers)[:, :, 0]  # the value of the cubic at the centre
    window = a[np.concatenate([centre[:, None], beside], 1)]
    bright = np.min(window, 1) > _FAINT * np.max(deviation[rows])
    if sweep.phase is None:
        squared, share = _plain(a, centre, beside, weights, bright)
    else:
        squared, share = _complex(a, sweep.phase[rows], centre, beside, weights, bright)
    good = np.isfinite(squared) & np.all(np.isfinite(share), 1)
    return _Scatter(squared[good], share[good]) if np.any(good) else None


def _plain(
    a: np.ndarray, centre: np.ndarray, beside: np.ndarray, weights: np.ndarray, bright: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Relative residuals without phase: of 1/a² where the noise is small beside a, else of a itself."""
    power = np.where(bright, -2.0, 1.0)
    parts = weights * (a[beside] / a[centre][:, None]) ** power[:, None]
    residual = (1.0 - parts.sum(1)) / power
    gain = np.concatenate([np.ones((len(centre), 1)), parts], 1) ** 2
    near = a[np.concatenate([centre[:, None], beside], 1)]
    return residual**2, np.stack([(gain / near**2).sum(1), gain.sum(1), np.zeros(len(centre))], 1)


def _complex(
    a: np.ndarray, phase: np.ndarray, centre: np.ndarray, beside: np.ndarray, weights: np.ndarray, bright: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Relative residuals along and across the response: of 1/H, or where it is faint of H."""
    power = np.where(bright, -1.0, 1.0)
    ratio = (a[beside] / a[centre][:, None]) ** power[:, None]
    turn = power[:, None] * (phase[beside] - phase[centre][:, None])
    parts = weights * ratio * np.exp(1j * turn)
    residual = 1.0 - parts.sum(1)
    near = a[np.concatenate([centre[:, None], beside], 1)]
    whole = np.concatenate([np.ones((len(centre), 1)), parts], 1)
    along, across = whole.real**2, whole.imag**2
    constant = ((along + across) / near**2).sum(1)
    one = np.stack([constant, along.sum(1), across.sum(1)], 1)
    other = np.stack([constant, across.sum(1), along.sum(1)], 1)
    return np.concatenate([residual.real**2, residual.imag**2]), np.concatenate([one, other])


def _variances(scatter: _Scatter) -> tuple[np.ndarray, np.ndarray]:
    """(3,) σ², r², σ_φ² and the covariance of their errors: reweighted least squares on the squared residuals.

    The weights 1/variance² make it the likelihood equation of Gaussian residuals; what is beyond `_CLIP` is clipped.
    """
    used = np.flatnonzero(np.any(scatter.share > 0, 0))
    scale = np.array([np.median(scatter.squared / np.maximum(scatter.share[:, k], 1e-300)) for k in used]) / 0.455
    scale = np.maximum(scale, 1e-300)
    share = scatter.share[:, used] * scale
    theta = np.full(len(used), 1.0 / len(used))
    for _ in range(60):
        expected = np.maximum(share @ theta, 1e-300)
        squared = np.minimum(scatter.squared, _CLIP**2 * expected) / _KEPT
        new = nnls(share / expected[:, None], squared / expected)[0]
        done = np.max(np.abs(new - theta)) < 1e-6 * np.max(np.abs(new))
        theta = 0.5 * theta + 0.5 * new
        if done:
            break
    expected = np.maximum(share @ theta, 1e-300)
    weighted = share / expected[:, None]
    # A point serves in five residuals, so that they hold about half the information of as many independent ones.
    covariance = np.linalg.pinv(weighted.T @ weighted / 2.0) * 2.0
    variances, errors = np.zeros(3), np.zeros((3, 3))
    variances[used] = theta * scale
    errors[np.ix_(used, used)] = covariance * np.outer(scale, scale)
    return variances, errors
