"""A linear stage, read by a sensor that saturates or reads less where the stage moves more; no simulator has a part."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Sweep
from ident.campaign.sweeps.noise import sweep_noise
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model

RESONANCE, QUALITY = 40.0, 25.0
PHASES = np.linspace(0, 2 * np.pi, 400, endpoint=False)


def bent_sweep(level: float, fold: float, steep: float, phase: bool, seed: int) -> Sweep:
    """Reading z − fold (z − tanh(steep z)/steep), which falls at last where fold > 1."""
    rising = RESONANCE * (1 + np.concatenate([np.linspace(-10, -2.5, 8), np.linspace(-2.2, 12, 34)]) / QUALITY)
    f, up = np.concatenate([rising, rising[::-1]]), np.arange(84) < 42
    motion = level / QUALITY / (1 - (f / RESONANCE) ** 2 + 1j * f / RESONANCE / QUALITY)
    z = np.abs(motion)[:, None] * np.cos(PHASES)
    reading = z - fold * (z - np.tanh(steep * z) / steep)
    size = 2 * np.mean(reading * np.cos(PHASES), axis=1)
    rng = np.random.default_rng(seed)
    white = lambda: rng.standard_normal(84)
    seen = size * np.exp(1j * np.angle(motion)) * (1 + 2e-3 * white()) * np.exp(2e-3j * white())
    seen += 5e-4 * (white() + 1j * white())
    return sweep_noise(
        Sweep(f"{level:.3g} V", f, np.full(84, level), np.abs(seen), np.angle(seen) if phase else None, up,
              "fundamental", Channel("V", 1.0), Channel("m", 1.0), NoiseFloor(0.0))
    )  # fmt: skip


@pytest.mark.parametrize("phase", [True, False], ids=["phase", "amplitude"])
@pytest.mark.parametrize(("fold", "steep"), [(0.8, 1.5), (1.0, 2.0), (2.5, 1.0)], ids=["weak", "saturates", "folds"])
def test_a_bent_characteristic_is_found_from_the_linear_model(fold: float, steep: float, phase: bool) -> None:
    sweeps = tuple(bent_sweep(level, fold, steep, phase, k) for k, level in enumerate((1 / 3, 2 / 3, 1.0)))
    device = Oscillator(output="m")
    found = fit(Model(device) + built_in()["sensor-nonlinearity"](device), Campaign("", sweeps, device))
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.1)
    assert found["frequency"].value == pytest.approx(RESONANCE, abs=0.002)
    assert found["quality"].value == pytest.approx(QUALITY, abs=0.15)
    # The library's law follows the hyperbolic tangent to a few tenths of a per cent of the reading.
    assert found["cubic"].value == pytest.approx(fold * steep**2 / 3, rel=0.03)
    assert "held" in found["quadratic"].flags and found["quadratic"].value == 0.0
