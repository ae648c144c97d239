"""Make `data/platform_sweeps`, the device of `data/platform_317hz` swept: `python -m experiments.make_sweeps`.

Seeds are fixed: the files come out byte for byte the same. `tests/experiments/test_sweep_campaign.py` simulates points
again and asserts every number that PROVENANCE.md claims.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.curves.sweeps import READ, fundamental
from experiments.make_campaigns import DATA, PAPER, TRUTHS
from experiments.simulator.files import Column, write_campaign, write_csv, write_truth
from experiments.simulator.signals import sine
from experiments.simulator.stage import Stage, simulate

NAME = "platform_sweeps"
SEED = 6
LEVELS = (3.0, 5.0, 7.0, 9.0)
HELD_OUT = 7.0
FREQUENCIES = np.concatenate([np.arange(440, 490, 5.0), np.arange(490, 526, 1.0), np.arange(530, 561, 5.0)])
SETTLED = 1200
"""Periods that each frequency is held before the lock-in reads it, 2.4 s. A ring-down needs 140 to fall to 1e-6, but at
512 Hz and 9 V, where the curve is about to bend over, the motion settles ten times more slowly."""
SAMPLES = 64  # per period
CONSTANT, RELATIVE, PHASE = 10e-9, 0.002, np.radians(0.2)  # noise: m, fraction of the amplitude, rad
COLUMNS = (
    Column("frequency (Hz)", 1, 3), Column("drive (V)", 1, 3), Column("amplitude (um)", 1e6, 4),
    Column("phase (deg)", 180 / np.pi, 2), Column("direction", 1, 0),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Passed:
    """One pass at a level (V): frequencies (Hz) in their order, and complex amplitudes (m) relative to the drive."""

    level: float
    up: bool
    frequency: np.ndarray
    response: np.ndarray


def passes(level: float, stage: Stage = PAPER, frequencies: np.ndarray = FREQUENCIES) -> tuple[Passed, Passed]:
    """Up from rest and then down again, the state carried from each frequency to the next, without noise.

    Each frequency is held for whole periods, so that the drive goes on without a jump.
    """
    found, state = [], (0.0, 0.0)
    for up in (True, False):
        order = frequencies if up else frequencies[::-1]
        response = []
        for f in order:
            t = np.arange((SETTLED + READ) * SAMPLES + 1) / (SAMPLES * f)
            z, v = simulate(stage, sine(level, f), t, start=state, substeps=4)
            state = (float(z[-1]), float(v[-1]))
            window = slice(-READ * SAMPLES - 1, -1)
            response.append(fundamental(z[window], 2 * np.pi * f * t[window]))
        found.append(Passed(level, up, order, np.array(response)))
    return found[0], found[1]


def measured(one: Passed) -> np.ndarray:
    """The responses of a pass with the noise of its lock-in, (k,) m."""
    rng = np.random.default_rng([SEED, round(one.level), int(one.up)])
    n = len(one.response)
    gain = (1 + RELATIVE * rng.standard_normal(n)) * np.exp(1j * PHASE * rng.standard_normal(n))
    return one.response * gain + CONSTANT * (rng.standard_normal(n) + 1j * rng.standard_normal(n))


def table(level: float) -> tuple[np.ndarray, ...]:
    """The columns of a level's file in SI: up, then down."""
    both = passes(level)
    response = np.concatenate([measured(one) for one in both])
    frequency = np.concatenate([one.frequency for one in both])
    way = np.concatenate([np.full(len(one.frequency), 1.0 if one.up else -1.0) for one in both])
    return frequency, np.full(len(frequency), level), np.abs(response), np.angle(response), way


def make(folder: Path) -> None:
    """Write the campaign, except its PROVENANCE.md, which is kept by hand."""
    folder.mkdir(parents=True, exist_ok=True)
    records: list[dict[str, object]] = []
    for level in LEVELS:
        file = f"sweep_{level:g}V.csv"
        write_csv(folder / file, COLUMNS, table(level), comment=f"simulated, {NAME}")
        records.append({"file": file, "kind": "sweep", "holdout": level == HELD_OUT})
    head: dict[str, object] = {"title": "Stressed platform with hysteresis, swept up and down"}
    settings = {"residual-stress": {"closure": "axial-force"}}
    write_campaign(folder / "campaign.toml", head, ("residual-stress", "pzt-hysteresis"), settings, records)
    parameters, hidden, notes = TRUTHS["platform_317hz"]
    extra = {
        "effects": list(hidden),
        "noise": CONSTANT,
        "relative_noise": RELATIVE,
        "phase_noise": float(PHASE),
    } | notes
    write_truth(folder / "truth.toml", parameters, extra)


if __name__ == "__main__":
    make(DATA / NAME)
