"""What stands in for the paper's measurements: the nominal device simulated by `experiments.simulator`.

The simulator shares no code with `ident`: closed form of the stiffness, fine Runge-Kutta steps in numba, noise added.
"""

from __future__ import annotations

import numpy as np

from experiments.simulator import noise
from experiments.simulator.signals import sine
from experiments.simulator.stage import Stage, resonance, simulate

from .nominal import CLOSURE, PARAMETERS, POINTS, Sine

NOISE = 30e-9  # m


def stage() -> Stage:
    """The nominal device in the simulator's words."""
    own = {name.split(".")[1]: value for name, value in PARAMETERS.items() if not name.endswith("sigma2")}
    return Stage(closure=CLOSURE, cubic=own.pop("k3"), **own)


def record(drive: Sine, periods: int, settle: int = 0, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time (s), drive (V) and noisy displacement (m) of so many periods, after others that are let pass."""
    wave = sine(drive.volts, drive.hertz)
    time = np.arange((settle + periods) * POINTS) / (POINTS * drive.hertz)
    moved = simulate(stage(), wave, time, load=drive.load)[0]
    kept = slice(settle * POINTS, None)
    random = np.random.default_rng([20, 3959, seed])
    return time[: periods * POINTS], wave.value(time)[kept], (moved + noise.white(random, len(moved), NOISE))[kept]


def swing(volts: float, hertz: np.ndarray) -> np.ndarray:
    """Half of the peak-to-peak at stepped frequencies (n,) Hz, m."""
    return resonance(stage(), volts, hertz)
