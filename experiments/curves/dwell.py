"""What points do that had not settled beside a jump: `python -m experiments.curves.dwell`.

A hardening beam with quadratic damping is swept up and down at three levels. Each frequency is held for 1.5 to 3 times
the quality factor in periods, five to nine times the ring-up, as laboratories do it; near the folds that is too short.
The sweeps are fitted with the right model, once with all points and once with those that `ident` counts. Transients are
integrated here; no part of the tool has a share in them.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import tempfile
from pathlib import Path
from unittest.mock import patch

import numpy as np
from numba import njit

from experiments.simulator.files import Column, write_campaign, write_csv
from ident import runtime

runtime.configure()

from ident.campaign import read_campaign  # noqa: E402  (JAX must be configured first)
from ident.fit import Fit, fit  # noqa: E402
from ident.model import build_model  # noqa: E402

FREQUENCY, QUALITY, SIZE = 12430.0, 160.0, 1e-6  # Hz; m, which a linear device would reach at 1 V
OWN = 2 * np.pi * FREQUENCY
CUBIC, DRAG = 0.05 * OWN**2 / SIZE**2, 0.25 / QUALITY / SIZE
TRUE = {"oscillator.frequency": FREQUENCY, "oscillator.quality": QUALITY,
        "cubic-stiffness.k3": CUBIC, "quadratic-damping.c2": DRAG}  # fmt: skip
LEVELS = (0.3, 0.8, 1.5)  # V
CASES = ((5001, 240), (5002, 320), (5003, 480), (5004, 240))  # seed, periods that a frequency is held
READ, STEPS = 20, 128  # periods that the lock-in averages; steps a period
CONSTANT, RELATIVE, PHASE = 0.4e-9, 1e-3, 2e-3  # noise: m, fraction of the amplitude, rad
COLUMNS = (
    Column("frequency (Hz)", 1, 3), Column("drive (V)", 1, 3), Column("amplitude (nm)", 1e9, 5),
    Column("phase (deg)", 180 / np.pi, 4), Column("direction", 1, 0),
)  # fmt: skip


@njit
def responses(frequencies, push, periods):
    """Complex amplitudes of a stepped sine, the state carried from each frequency to the next (Runge-Kutta 4), m."""
    found, z, v = np.zeros(len(frequencies), np.complex128), 0.0, 0.0
    drive = push * np.cos(np.pi / STEPS * np.arange(2 * STEPS + 1))
    for i in range(len(frequencies)):
        h = 1.0 / frequencies[i] / STEPS
        for period in range(periods):
            for k in range(STEPS):
                if period >= periods - READ:
                    found[i] += 2.0 / (READ * STEPS) * z * np.exp(-2j * np.pi * k / STEPS)
                a = rate(z, v, drive[2 * k])
                b = rate(z + h / 2 * v, v + h / 2 * a, drive[2 * k + 1])
                c = rate(z + h / 2 * v + h * h / 4 * a, v + h / 2 * b, drive[2 * k + 1])
                d = rate(z + h * v + h * h / 2 * b, v + h * c, drive[2 * k + 2])
                z, v = z + h * v + h * h / 6 * (a + b + c), v + h / 6 * (a + 2 * b + 2 * c + d)
    return found


@njit
def rate(z, v, u):
    """Acceleration, m/s²."""
    return u - OWN * OWN * z - OWN / QUALITY * v - CUBIC * z**3 - DRAG * abs(v) * v


def write(seed: int, periods: int, folder: Path) -> None:
    """A campaign of one table a level."""
    rng = np.random.default_rng([seed, 43])
    rising = np.linspace(12250, 12780, 107) + rng.uniform(-2, 2)
    order, records = np.concatenate([rising, rising[::-1]]), []
    n, way = len(order), np.repeat([1.0, -1.0], len(rising))
    for level in LEVELS:
        seen = responses(order, OWN**2 * SIZE / QUALITY * level, periods)
        seen = seen * (1 + RELATIVE * rng.standard_normal(n)) * np.exp(1j * PHASE * rng.standard_normal(n))
        seen += CONSTANT * (rng.standard_normal(n) + 1j * rng.standard_normal(n))
        write_csv(
            folder / f"sweep_{level}V.csv", COLUMNS, (order, np.full(n, level), np.abs(seen), np.angle(seen), way)
        )
        records.append({"file": f"sweep_{level}V.csv", "kind": "sweep"})
    head: dict[str, object] = {"title": "A beam in a hurry", "device": {"kind": "oscillator", "output": "m"}}
    write_campaign(folder / "campaign.toml", head, ("cubic-stiffness", "quadratic-damping"), {}, records)


def told(found: Fit) -> tuple[float, np.ndarray]:
    """Print a fit; its error over noise, and the errors of its parameters in standard errors."""
    off = np.array([(found[name].value - true) / (found[name].error or np.nan) for name, true in TRUE.items()])
    error = found.fitted.error_over_noise
    print(f"  error over noise {error:.3f}, quality factor {found.value('oscillator.quality'):.2f}; off by "
          + ", ".join(f"{x:+.1f}" for x in off) + " standard errors")  # fmt: skip
    return error, off


def main() -> None:
    """Fit every case both ways, print and assert."""
    without, all_points = [], []
    for seed, periods in CASES:
        print(f"seed {seed}, {periods / QUALITY:.1f} Q periods a point: all points, then those that count")
        with tempfile.TemporaryDirectory() as name:
            write(seed, periods, Path(name))
            campaign = read_campaign(name)
            with patch("ident.fit.curves.settled", lambda sweep, _: np.ones(len(sweep.frequency), bool)):
                all_points.append(told(fit(build_model(campaign), campaign)))
            without.append(told(fit(build_model(campaign), campaign)))
    worst = np.array([np.max(np.abs(off)) for _, off in all_points])
    off = np.concatenate([off for _, off in without])
    errors = [[e for e, _ in some] for some in (all_points, without)]
    print(f"all points: error over noise {min(errors[0]):.1f} to {max(errors[0]):.1f}, "
          f"farthest parameter {np.min(worst):.0f} to {np.max(worst):.0f} standard errors off")  # fmt: skip
    print(f"those that count: error over noise {min(errors[1]):.2f} to {max(errors[1]):.2f}, {len(off)} parameters "
          f"with rms {np.sqrt(np.mean(off**2)):.2f}, largest {np.max(np.abs(off)):.1f}")  # fmt: skip
    # Held for 1.5 Q, every point is off by what a ring-up leaves then, a hundredth of the last step.
    assert max(errors[1]) < 1.2 and np.max(np.abs(off)) < 4 < np.min(worst)


if __name__ == "__main__":
    main()
