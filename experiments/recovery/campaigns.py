"""Simulated campaigns with random truths: platform, residual stress and hysteresis, five records of 1600 samples.

The simulator is the independent one of `experiments/simulator`; only the container types come from `ident`.

Ranges, uniform unless said otherwise and drawn independently: f0 450–550 Hz, Q 20–45, d31 40–80 pm/V, σ12 ±(40–120)
MPa, σ23/σ12 0.3–0.8, restraint 0.2–0.8 (logarithmic), β_V ±(2–8) mN/V, η and ζ (1–3)·10⁻²³ m³/V³, noise 20–60 nm.
Nothing that is drawn is thrown away. The strongest record moves by some 15 to 120 µm; no segment comes nearer to
buckling than a sixth of the way (asserted in the tests).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from experiments.simulator import noise
from experiments.simulator.signals import Drive, Tones, multisine, sine
from experiments.simulator.stage import Stage, simulate
from ident.campaign.campaign import Campaign
from ident.campaign.noise.floor import noise_floor
from ident.campaign.noise.pool import pooled
from ident.campaign.period import find_period
from ident.campaign.record import Channel, NoiseFloor, Start, Trace

SAMPLES = 1600
DRIVE_NOISE = 3e-4
PREROLL = 3  # periods of the drive's pattern before a record that does not start at rest

NoiseKind = Literal["white, given", "white, estimated", "coloured, given", "coloured, estimated"]
KINDS: tuple[NoiseKind, ...] = get_args(NoiseKind)

PARAMETERS = {
    "platform.frequency": "frequency",
    "platform.quality": "quality",
    "platform.d31": "d31",
    "residual-stress.sigma12": "sigma12",
    "residual-stress.sigma23": "sigma23",
    "residual-stress.restraint": "restraint",
    "residual-stress.voltage_force": "voltage_force",
    "pzt-hysteresis.eta": "eta",
    "pzt-hysteresis.zeta": "zeta",
}
"""Full name of each parameter in the tool, and its name in the simulator."""


@dataclass(frozen=True)
class Plan:
    """One record: `drive`; `pattern`, samples after which it repeats; `step` s; whether it is cut out of a motion."""

    name: str
    drive: Drive
    step: float
    pattern: int
    cut: bool


@dataclass(frozen=True, eq=False)
class Case:
    """One campaign: what the lab would have, and what is true. `pure`: displacements without noise, m."""

    campaign: Campaign
    stage: Stage
    kind: NoiseKind
    pure: tuple[np.ndarray, ...]

    @property
    def truth(self) -> dict[str, float]:
        """True values by full parameter name, SI."""
        return {name: float(getattr(self.stage, field)) for name, field in PARAMETERS.items()}


def draw_stage(rng: np.random.Generator) -> Stage:
    """A random device."""
    sign = lambda: rng.choice([-1.0, 1.0])
    sigma12 = sign() * rng.uniform(40e6, 120e6)
    return Stage(
        frequency=rng.uniform(450, 550),
        quality=rng.uniform(20, 45),
        d31=rng.uniform(40e-12, 80e-12),
        closure="axial-force",
        sigma12=sigma12,
        sigma23=sigma12 * rng.uniform(0.3, 0.8),
        restraint=float(np.exp(rng.uniform(np.log(0.2), np.log(0.8)))),
        voltage_force=sign() * rng.uniform(2e-3, 8e-3),
        eta=rng.uniform(1e-23, 3e-23),
        zeta=rng.uniform(1e-23, 3e-23),
    )


def plans(frequency: float, seed: int) -> list[Plan]:
    """Five records around a natural frequency (Hz): sines below, near and above it, weak and strong, and a multisine.

    All hold whole periods, so that a record's own drive frequency, which the hysteresis polynomial needs, is that of
    the simulation however long the motion before it was.
    """
    found = []
    for name, volts, ratio, samples, cut in (
        ("far", 8.0, 0.63, 100, False),
        ("weak", 3.0, 1.00, 80, True),
        ("strong", 9.0, 1.02, 80, False),
        ("below", 6.0, 0.86, 80, True),
    ):
        hertz = round(ratio * frequency)
        found.append(Plan(name, sine(volts, hertz), 1 / (samples * hertz), samples, cut))
    base = round(frequency / 10)
    tones = multisine(6.0, base * np.arange(3.0, 14.0), seed)
    found.append(Plan("multisine", tones, 1 / (800 * base), 800, False))
    return found


def draw(seed: int) -> Case:
    """The campaign of one seed; the kinds of noise take turns."""
    rng = np.random.default_rng([20, seed])
    stage, kind = draw_stage(rng), KINDS[seed % len(KINDS)]
    deviation = rng.uniform(20e-9, 60e-9)
    memory = rng.uniform(0.5, 0.9) if kind.startswith("coloured") else 0.0
    records, pure = [], []
    for plan in plans(stage.frequency, seed):
        z = _motion(plan, stage)
        records.append(_measured(plan, z, rng, deviation, memory))
        pure.append(z)
    if kind.endswith("estimated"):
        records = _with_estimated_noise(records)
    return Case(Campaign(f"recovery {seed}", tuple(records)), stage, kind, tuple(pure))


def _motion(plan: Plan, stage: Stage) -> np.ndarray:
    before = PREROLL * plan.pattern if plan.cut else 0
    t = plan.step * np.arange(-before, SAMPLES)
    drive = _shifted(plan.drive, -before * plan.step)
    return simulate(stage, drive, t + before * plan.step)[0][before:]


def _shifted(drive: Drive, start: float) -> Drive:
    """The drive as seen on a clock that starts at `start`; whole patterns leave it as it is."""
    assert isinstance(drive, Tones)
    return Tones(drive.amplitudes, drive.frequencies, drive.phases + 2 * np.pi * drive.frequencies * start, drive.bias)


def _measured(plan: Plan, z: np.ndarray, rng: np.random.Generator, deviation: float, memory: float) -> Trace:
    t = plan.step * np.arange(SAMPLES)
    volts = plan.drive.value(t) + noise.white(rng, SAMPLES, DRIVE_NOISE)
    response = z + noise.autoregressive(rng, SAMPLES, deviation, memory)
    floor = NoiseFloor(deviation, (memory,) if memory else (), "given")
    start: Start = "unknown" if plan.cut else "rest"
    channels = Channel("V", 1.0), Channel("m", 1.0)
    return Trace(plan.name, t, volts, response, *channels, floor, start=start, period=find_period(volts))


def _with_estimated_noise(records: list[Trace]) -> list[Trace]:
    """The records with the noise floors that `ident` reads off them, as reading a campaign does."""
    floors = [noise_floor(r.time, r.drive, r.response, r.period) for r in records]
    floors = pooled(floors, [len(r.time) for r in records])
    return [replace(record, noise=floor) for record, floor in zip(records, floors, strict=True)]
