"""A law of any power is that in weak records, too: its reference is the largest motion of all."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.effects.library.power_law_damping import PowerLawDamping
from ident.effects.library.power_law_stiffness import PowerLawStiffness
from ident.fit.reading import read
from ident.model import Model

F0, Q, GAIN, STEP = 100.0, 20.0, 4e5, 1 / 6000.0
OMEGA = 2 * np.pi * F0
LARGEST = GAIN / OMEGA**2 * Q


@pytest.mark.parametrize("level", [1.0, 0.02])
@pytest.mark.parametrize(
    ("effect", "power", "size", "reference"),
    [
        (PowerLawDamping(), 0.45, 0.1 * OMEGA / Q, LARGEST * OMEGA),
        (PowerLawDamping(), 1.5, 0.5 * OMEGA / Q, LARGEST * OMEGA),
        (PowerLawStiffness(), 0.7, 0.02 * OMEGA**2, LARGEST),
        (PowerLawStiffness(), 1.5, 0.1 * OMEGA**2, LARGEST),
    ],
    ids=["damping-0.45", "damping-1.5", "stiffness-0.7", "stiffness-1.5"],
)
def test_a_record_fifty_times_weaker_obeys_the_same_law(effect, power, size, reference, level) -> None:
    """|v|^0.45 had been linear below a hundredth of the largest velocity: a weak record was 10 noise floors off, and
    its trigger was called late."""
    by_velocity = isinstance(effect, PowerLawDamping)
    size = size * np.sign(power - 1)
    time, volt = STEP * np.arange(1200), Channel("V", 1.0)
    drive = lambda t: level * np.sin(2 * np.pi * 93.0 * t)

    def law(x: float) -> float:
        ratio = abs(x / reference) + 1e-9
        return x * (ratio ** (power - 1) - 1) / (power - 1)

    def rates(t: float, y: np.ndarray) -> tuple[float, float]:
        force = size * law(y[int(by_velocity)])
        return y[1], GAIN * drive(t) - OMEGA**2 * y[0] - OMEGA / Q * y[1] - force

    tiny = 1e-9 * level * np.array([LARGEST, LARGEST * OMEGA])
    exact = solve_ivp(rates, (0, time[-1]), (0.0, 0.0), "Radau", time, rtol=1e-7, atol=tiny, max_step=STEP).y[0]
    noise = 1e-3 * float(np.std(exact))
    record = Trace("a.csv", time, drive(time), np.zeros_like(time), volt, volt, NoiseFloor(noise), "rest")
    told = read(Model(Oscillator()) + effect, np.array([F0, Q, GAIN, size, power, reference]), [record])[0]
    assert float(np.std(told - exact)) < noise
