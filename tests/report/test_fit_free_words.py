"""What curves with phase tell before any fit, on points that obey a law of the amplitude exactly."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from ident.campaign.record import Channel, NoiseFloor, Sweep
from ident.report.words.sweeps import fit_free_words

OWN, RATE, RELATIVE = 2 * np.pi * 200.0, 25.0, 1e-3


def stopped(amplitude: np.ndarray) -> np.ndarray:
    """Ω² of a spring with a stop of 0.8 its stiffness on both sides at 1: its describing function,
    1 − (2/π)(asin r + r √(1 − r²)), r = 1/A (A. Gelb, W. E. Vander Velde, 1968, ch. 2)."""
    r = np.minimum(1 / amplitude, 1.0)
    return OWN**2 * (1 + 0.8 * (1 - 2 / np.pi * (np.arcsin(r) + r * np.sqrt(1 - r**2))))


def turning(amplitude: np.ndarray) -> np.ndarray:
    """Ω² of a spring that softens, then hardens."""
    return OWN**2 * (1 - 0.03 * amplitude**2 + 0.006 * amplitude**4)


def sweep(level: float, law: Callable[[np.ndarray], np.ndarray], rng: np.random.Generator) -> Sweep:
    """Points below and above the resonance at even amplitudes: |Ω²(A) − ω² + iωΓ| A = U solved for ω."""
    amplitude = np.linspace(0.05, 1.0, 60) * 0.8 * level
    stiff, drive = law(amplitude), level * OWN * RATE
    half = np.sqrt((drive / amplitude) ** 2 - RATE**2 * stiff + RATE**4 / 4)
    square = np.concatenate([stiff - RATE**2 / 2 - half, stiff - RATE**2 / 2 + half])
    stiff, good = np.tile(stiff, 2), square > 0.5 * OWN**2
    omega = np.sqrt(square[good])
    response = drive / (stiff[good] - omega**2 + 1j * omega * RATE)
    response *= np.exp(RELATIVE * (rng.standard_normal(len(omega)) + 1j * rng.standard_normal(len(omega))))
    order = np.argsort(omega)
    n, unit = len(order), Channel("m", 1.0)
    return Sweep(f"{level} V", omega[order] / (2 * np.pi), np.full(n, level), np.abs(response)[order],
                 np.angle(response)[order], np.ones(n, bool), "fundamental", Channel("V", 1.0), unit,
                 NoiseFloor(1e-7), relative_noise=RELATIVE, phase_noise=RELATIVE)  # fmt: skip


@pytest.mark.parametrize(("law", "words"), [(stopped, "rises with"), (turning, "and rises to")])
def test_levels_of_one_law_fall_on_one_curve_however_it_bends(law, words: str) -> None:
    rng = np.random.default_rng(4)
    stiffness, damping = fit_free_words([sweep(level, law, rng) for level in (0.5, 1.2, 2.6)])
    assert words in stiffness and "all levels fall on one curve" in stiffness
    assert f"does not change with the velocity, {RATE:.3g}" in damping


def test_levels_of_different_devices_do_not() -> None:
    rng = np.random.default_rng(4)
    sweeps = [sweep(0.5, stopped, rng), sweep(1.2, stopped, rng), sweep(2.6, turning, rng)]
    assert "do not fall on one curve" in fit_free_words(sweeps)[0]
