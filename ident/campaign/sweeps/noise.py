"""The noise of an amplitude-frequency curve, from how far each point leaves the curve through its neighbours.

Not the amplitude is interpolated but the dynamic stiffness 1/H (without phase: 1/a²), which a linear resonance makes a
polynomial of the frequency, so that the peak is not taken for noise; jumps cut a run in two.
"""

from __future__ import annotations

from dataclasses import replace
from functools import reduce

import numpy as np

from ..record import NoiseFloor, Sweep
from .jump import unbroken
from .variances import Scatter, shares, variances_of
from .way_back import way_back

_NEAR = (-2, -1, 1, 2)
_WIDE = (-3, -1, 1, 3)
_AROUND = (-3, -2, -1, 1, 2, 3)
_FAINT = 8.0  # standard deviations below which 1/a is no longer linear in the noise: there the amplitude itself serves
_BENT = 2.0
"""Two cubics, through near and through wider neighbours, differ by 1.25 times the error of the nearer one, but by 0.3 σ
only from noise. Where they differ by more than twice that, the points are too far apart to show their noise."""
_FEWEST = 8
_ALIKE = 2.0  # a point serves in five residuals: they hold about half the information of as many independent ones
_FINEST = 1e-9  # of the largest amplitude: finer steps are those of rounding


def sweep_noise(sweep: Sweep) -> Sweep:
    """The sweep with the noise that its points show: a constant and a relative part, and that of the phase.

    The variances of the residuals are linear in (σ², r², σ_φ²), found by the likelihood of Gaussian residuals.
    Where the points show no scatter, or are too few or too far apart, `noise.method` says what is assumed.

    On simulated curves of 8 × 40 points (tests/campaign/test_sweep_noise.py) the estimate is 3 % low, with 7 % scatter;
    at the top of curves that bend or jump it is up to 1.6 times too large, without phase up to twice.
    """
    size = float(np.sqrt(np.mean(sweep.amplitude**2)))
    scatter = _scatter(sweep, None)
    if scatter is None or len(scatter.squared) < _FEWEST:
        method = "assumed: 1 % of the rms amplitude (too few points to tell)"
        floor = NoiseFloor(0.01 * size, method=method, relative_error=1.0)
        return replace(sweep, noise=floor, relative_noise=0.0, phase_noise=0.01)
    variances, errors = variances_of(scatter)
    upper = False
    for _ in range(8):
        found = _noisy(sweep, variances)
        fewer = _scatter(found, variances)
        upper = fewer is None or len(fewer.squared) < _FEWEST
        if fewer is None or upper:
            break
        scatter, before = fewer, variances
        variances, errors = variances_of(scatter)
        if np.allclose(variances, before, rtol=0.02):
            break
    again = None if upper else way_back(sweep, variances)
    if again is not None:
        variances, errors = variances_of(scatter.beside(again))
    return _said(_noisy(sweep, variances), variances, errors, len(scatter.squared), size, upper)


def _noisy(sweep: Sweep, variances: np.ndarray) -> Sweep:
    sigma, relative, phase = (float(x) for x in np.sqrt(variances))
    return replace(sweep, noise=NoiseFloor(sigma), relative_noise=relative, phase_noise=phase)


def _said(sweep: Sweep, variances: np.ndarray, errors: np.ndarray, count: int, size: float, upper: bool) -> Sweep:
    """The sweep with its noise in words, and the resolution of the table as the least floor."""
    typical = float(np.median(sweep.deviation))
    if typical < 1e-6 * size:
        method = "assumed: 0.1 % of the rms amplitude (the points show no scatter)"
        floor = NoiseFloor(1e-3 * size, method=method, relative_error=1.0)
        return replace(sweep, noise=floor, relative_noise=0.0, phase_noise=max(sweep.phase_noise, 1e-4))
    least = max(_resolution(sweep.amplitude) / np.sqrt(12.0), 1e-3 * typical)
    share = np.array([1.0, float(np.median(sweep.amplitude)) ** 2, 0.0])
    error = 0.5 * float(np.sqrt(share @ errors @ share)) / max(float(share @ variances), 1e-300)
    parts = [f"{100 * sweep.relative_noise:.2g} % of the amplitude"] if sweep.relative_noise > 1e-5 else []
    parts += [f"{np.degrees(sweep.phase_noise):.2g}° of phase"] if sweep.phase is not None else []
    beside = f", and {', '.join(parts)}" if parts else ""
    method = f"scatter of {count} residuals of points about their neighbours{beside}"
    if upper:
        method += "; an upper estimate, because the points are too far apart to show it"
    floor = NoiseFloor(max(sweep.noise.sigma, least), (), method, 1.0 if upper else max(error, 0.05))
    return replace(sweep, noise=floor)


def _resolution(amplitude: np.ndarray) -> float:
    """The step of which all differences of amplitudes are multiples (Euclid's algorithm): the smallest difference is
    none, for on a flank that was passed once all points lie far apart."""
    step, finest = 0.0, _FINEST * float(np.max(amplitude))
    for rest in np.diff(np.unique(amplitude)).tolist():
        while rest > finest:
            step, rest = rest, abs(step - round(step / rest) * rest)
    return step


def _scatter(sweep: Sweep, variances: np.ndarray | None) -> Scatter | None:
    """The residuals of all runs; with a first idea of the variances, of the points that lie near enough together."""
    found = [_of_piece(sweep, piece, variances) for piece in _pieces(sweep)]
    found = [one for one in found if one is not None]
    return reduce(Scatter.beside, found) if found else None


def _pieces(sweep: Sweep) -> list[np.ndarray]:
    """The rows of each run in the order of rising frequency, cut at its jump."""
    found = []
    for run in sweep.runs:
        found += unbroken(sweep, run.rising[sweep.amplitude[run.rising] > 0])
    return [rows for rows in found if len(rows) > len(_AROUND)]


def _of_piece(sweep: Sweep, rows: np.ndarray, variances: np.ndarray | None) -> Scatter | None:
    """Relative residuals of each inner point against the cubic through two neighbours on either side.

    Interpolated is 1/H, or 1/a² without phase; where the noise is not small beside a, H or a itself.
    """
    f, a = sweep.frequency[rows], sweep.amplitude[rows]
    phase = np.zeros(len(rows)) if sweep.phase is None else sweep.phase[rows]
    centre = np.arange(3, len(rows) - 3)
    around = centre[:, None] + np.array(_AROUND)
    near, wide = (_cubic(f, centre, offsets) for offsets in (_NEAR, _WIDE))
    sizes = a[np.concatenate([centre[:, None], around], 1)]
    bright = np.min(sizes, 1) > _FAINT * float(np.max(sweep.deviation[rows]))
    power = np.where(bright, -2.0 if sweep.phase is None else -1.0, 1.0)[:, None]
    ratio = (a[around] / a[centre][:, None]) ** power
    ratio = ratio * np.exp(1j * np.sign(power) * (phase[around] - phase[centre][:, None]))
    residual = (1.0 - (near * ratio).sum(1)) / np.abs(power[:, 0])
    along, across = shares(np.concatenate([np.ones((len(centre), 1)), near * ratio], 1), sizes)
    kept = np.isfinite(residual) & np.all(np.isfinite(along), 1)
    if variances is not None:
        bend = np.abs(((near - wide) * ratio).sum(1) / power[:, 0]) ** 2
        expected = sum(share @ variances for share in shares((near - wide) * ratio, sizes[:, 1:]))
        kept &= bend < _BENT**2 * expected
    if not np.any(kept):
        return None
    squared, share = (residual.real**2)[kept], along[kept]
    if sweep.phase is not None:
        squared = np.concatenate([squared, (residual.imag**2)[kept]])
        share = np.concatenate([share, across[kept]])
    return Scatter(squared, share, np.full(len(squared), _ALIKE))


def _cubic(frequency: np.ndarray, centre: np.ndarray, offsets: tuple[int, ...]) -> np.ndarray:
    """(m, 6) weights of the neighbours `_AROUND`, of which only `offsets` serve, for the value at each centre."""
    x = frequency[centre[:, None] + np.array(offsets)] - frequency[centre][:, None]
    steps = np.diff(frequency)
    steps = steps[steps > 0]  # a curve that was passed twice has each frequency twice
    x = x / (float(np.median(steps)) if len(steps) else 1.0)
    weights = np.zeros((len(centre), len(_AROUND)))
    weights[:, [_AROUND.index(k) for k in offsets]] = np.linalg.pinv(x[:, None, :] ** np.arange(4)[None, :, None])[
        ..., 0
    ]
    return weights
