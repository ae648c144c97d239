"""Small records of an oscillator, simulated by SciPy, that the tests of the posterior share."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from experiments.simulator.circuit import Circuit, simulate
from experiments.simulator.signals import multisine
from ident.campaign import Campaign, Channel, NoiseFloor, Oscillator, Trace
from ident.campaign.campaign import Prior

CIRCUIT = Circuit(frequency=71.3, quality=14.0, gain=1.9e5, cubic=6.0e4)
SIGMA = 4e-3
_VOLT = Channel("V", 1.0)


def record(
    seed: int, circuit: Circuit = CIRCUIT, samples: int = 500, lead: int = 0, memory: float = 0.0, doubt: float = 0.0,
    holdout: bool = False, sigma: float = SIGMA,
) -> Trace:  # fmt: skip
    """A multisine record; `lead`: samples cut off, so that it begins in motion; `memory` of the noise."""
    random = np.random.default_rng([77, seed])
    time = np.arange(samples + lead) * 2.5e-4 * 4
    drive = multisine(0.3, np.arange(20.0, 151.0, 10.0), seed)
    clean = simulate(circuit, drive, time)
    white = random.standard_normal(len(time) + 200) * np.sqrt(1 - memory**2)
    noise = sigma * lfilter([1.0], [1.0, -memory], white)[200:]
    floor = NoiseFloor(sigma, (memory,) if memory else (), "given in the campaign", doubt)
    t, v, z = time[lead:] - time[lead], drive.value(time)[lead:], (clean + noise)[lead:]
    return Trace(f"{seed}.csv", t, v, z, _VOLT, _VOLT, floor, start="unknown" if lead else "rest", holdout=holdout)


def campaign(*records: Trace, priors: dict[str, Prior] | None = None, **settings: dict) -> Campaign:
    """A campaign of an oscillator in volts."""
    return Campaign("small", records, Oscillator(), settings=settings, priors=priors or {})
