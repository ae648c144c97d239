"""Make the five small campaigns in `data/`: `python -m experiments.make_campaigns`.

Seeds are fixed: the files come out byte for byte the same. `tests/experiments` re-simulates records and asserts every
number that the PROVENANCE files claim.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from experiments.simulator import circuit, noise
from experiments.simulator.files import Column, write_campaign, write_csv, write_truth
from experiments.simulator.geometry import Geometry
from experiments.simulator.signals import Chirp, Drive, multisine, sine
from experiments.simulator.stage import Stage, simulate

DATA = Path(__file__).resolve().parents[1] / "data"

# First part of every record's seed.
SEEDS = {"oscillator": 0, "platform_317hz": 1, "platform_clean": 2, "platform_fe": 3, "mystery_platform": 4}

# A stress without mean force: with σ2 = 0, σ12 Tp = σ23 Ts, so that only its moment acts. This moment (N·m) is the one
# of the finite-element curves; it lifts the stage by 2.8 µm.
MOMENT = 2.1461529474e-5
_PER_PASCAL = Geometry().residual_moment(1.0, 0.0, -17.0 / 30.0)
SIGMA12 = MOMENT / _PER_PASCAL
SIGMA23 = SIGMA12 * 17.0 / 30.0

PAPER = Stage(
    frequency=498.6, quality=31.0, d31=64e-12, closure="axial-force", sigma12=SIGMA12, sigma23=SIGMA23,
    restraint=0.38, voltage_force=5e-3, eta=2.2e-23, zeta=1.7e-23,
)  # fmt: skip
CLEAN = Stage(frequency=503.2, quality=35.0, d31=30e-12)
FINITE_ELEMENT = Stage(frequency=499.5, quality=33.0, d31=40e-12, closure="curve", sigma12=SIGMA12, sigma23=SIGMA23)
MYSTERY = Stage(
    frequency=501.7, quality=33.0, d31=58e-12, closure="axial-force", sigma12=0.8 * SIGMA12, sigma23=0.8 * SIGMA23,
    restraint=0.31, friction=20e-6, friction_speed=1e-3,
)  # fmt: skip
CIRCUIT = circuit.Circuit(frequency=71.3, quality=14.0, gain=1.9e5, cubic=6.0e4)


@dataclass(frozen=True)
class Plan:
    """One record: file name, drive, duration (s), samples, held out or not, extra load (kg)."""

    file: str
    drive: Drive
    duration: float
    samples: int
    holdout: bool = False
    load: float = 0.0

    @property
    def time(self) -> np.ndarray:
        return np.arange(self.samples) * (self.duration / self.samples)


def _sine(volts: float, hertz: float, holdout: bool = False, load: float = 0.0, periods: int = 25) -> Plan:
    mass = f"_{load * 1e6:.0f}mg" if load else ""
    return Plan(
        f"sine_{volts:g}V_{hertz:g}Hz{mass}.csv", sine(volts, hertz), periods / hertz, 80 * periods, holdout, load
    )


def _multisine(volts: float, seed: int, samples: int = 2000) -> Plan:
    return Plan(f"multisine_{volts:g}V.csv", multisine(volts, np.arange(120.0, 621.0, 20.0), seed), 0.05, samples, True)


PLANS: dict[str, list[Plan]] = {
    "platform_317hz": [
        _sine(8, 317), _sine(3, 500), _sine(6, 505), _sine(9, 510),
        _sine(5, 450, holdout=True), _sine(8, 317, holdout=True, load=40e-6), _multisine(6, 11),
    ],
    "platform_clean": [_sine(8, 317), _sine(3, 500), _sine(9, 505), _sine(5, 450, holdout=True), _multisine(6, 12)],
    "platform_fe": [
        _sine(8, 317), _sine(3, 505), _sine(6, 510), _sine(9, 515), _sine(5, 450, holdout=True), _multisine(6, 13),
    ],
    "mystery_platform": [
        *(_sine(*drive, periods=20) for drive in ((8, 317), (3, 500), (6, 505), (9, 510), (1.5, 503), (7, 470))),
        _sine(5, 450, holdout=True, periods=20), _sine(8, 317, holdout=True, load=40e-6, periods=20),
        _multisine(6, 31, samples=1600),
    ],
    "oscillator": [
        Plan("multisine_a.csv", multisine(0.35, np.arange(10.0, 151.0, 2.0), 21), 0.5, 2000),
        Plan("multisine_b.csv", multisine(0.15, np.arange(10.0, 151.0, 2.0), 22), 0.5, 2000),
        Plan("sine_75Hz.csv", sine(0.1, 75), 0.4, 1600),
        Plan("chirp_up.csv", Chirp(0.12, 40.0, 110.0, 0.5), 0.5, 2000, True),
        Plan("multisine_c.csv", multisine(0.45, np.arange(10.0, 151.0, 2.0), 23), 0.5, 2000, True),
    ],
}  # fmt: skip

STYLES: dict[str, tuple[tuple[Column, Column, Column], float, float]] = {  # columns, response noise, drive noise (SI)
    "platform_317hz": ((Column("Time_ms", 1e3, 6), Column("Drive_V", 1, 4), Column("z [um]", 1e6, 4)), 30e-9, 3e-4),
    "platform_clean": (
        (Column("time (s)", 1, 9), Column("drive (mV)", 1e3, 1), Column("displacement (nm)", 1e9, 1)), 25e-9, 3e-4,
    ),
    "platform_fe": ((Column("t [ms]", 1e3, 6), Column("Drive [V]", 1, 4), Column("z [um]", 1e6, 4)), 25e-9, 3e-4),
    "mystery_platform": ((Column("Time_ms", 1e3, 6), Column("Drive_V", 1, 4), Column("z [um]", 1e6, 4)), 30e-9, 3e-4),
    "oscillator": ((Column("t_ms", 1e3, 4), Column("u_V", 1, 6), Column("y_mV", 1e3, 4)), 3e-4, 5e-6),
}  # fmt: skip


STAGES = {
    "platform_317hz": PAPER, "platform_clean": CLEAN, "platform_fe": FINITE_ELEMENT, "mystery_platform": MYSTERY,
}  # fmt: skip


def finite_element_curve() -> tuple[np.ndarray, np.ndarray]:
    """z (m) and force per beam (N) at the stress of the campaigns, stage free to turn about z."""
    table = np.genfromtxt(
        DATA / "fe_beam" / "force_displacement.csv", delimiter=",", names=True, dtype=None, encoding="utf-8"
    )
    rows = table[(table["kappa_multiple"] == 1) & (table["stage_constraint"] == "rotz_c")]
    return np.asarray(rows["z_m"], float), np.asarray(rows["F_N_per_beam"], float)


def noiseless(name: str, plan: Plan) -> np.ndarray:
    """The response of one record without noise, SI."""
    if name == "oscillator":
        return circuit.simulate(CIRCUIT, plan.drive, plan.time)
    stage = STAGES[name]
    curve = finite_element_curve() if name == "platform_fe" else None
    return simulate(stage, plan.drive, plan.time, load=plan.load, curve=curve)[0]


def record(name: str, index: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, measured drive and measured response of one record, SI, as written (before rounding)."""
    plan, (_, response_noise, drive_noise) = PLANS[name][index], STYLES[name]
    rng = np.random.default_rng([SEEDS[name], index])
    t = plan.time
    drive = plan.drive.value(t) + noise.white(rng, len(t), drive_noise)
    return t, drive, noiseless(name, plan) + noise.white(rng, len(t), response_noise)


def _platform_truth(stage: Stage) -> dict[str, float]:
    return {"platform.frequency": stage.frequency, "platform.quality": stage.quality, "platform.d31": stage.d31}


def _stress_truth(stage: Stage) -> dict[str, float]:
    return {"residual-stress.sigma12": stage.sigma12, "residual-stress.sigma23": stage.sigma23}


TRUTHS: dict[str, tuple[dict[str, float], tuple[str, ...], dict[str, object]]] = {  # parameters, effects at work, notes
    "platform_317hz": (
        _platform_truth(PAPER) | _stress_truth(PAPER) | {
            "residual-stress.restraint": PAPER.restraint, "residual-stress.voltage_force": PAPER.voltage_force,
            "pzt-hysteresis.eta": PAPER.eta, "pzt-hysteresis.zeta": PAPER.zeta,
        }, ("residual-stress", "pzt-hysteresis"),
        {"closure": "axial-force", "residual_moment": MOMENT, "sigma2": 0.0},
    ),
    "platform_clean": (_platform_truth(CLEAN), (), {}),
    "platform_fe": (
        _platform_truth(FINITE_ELEMENT) | _stress_truth(FINITE_ELEMENT), ("residual-stress",),
        {"closure": "finite-element curve, stage free to turn about z", "residual_moment": MOMENT, "sigma2": 0.0},
    ),
    "mystery_platform": (
        _platform_truth(MYSTERY) | _stress_truth(MYSTERY) | {
            "residual-stress.restraint": MYSTERY.restraint, "coulomb-friction.friction": MYSTERY.friction,
        }, ("residual-stress", "coulomb-friction"),
        {"closure": "axial-force", "residual_moment": 0.8 * MOMENT, "sigma2": 0.0,
         "friction_law": "F_c v/sqrt(v^2 + v_c^2)", "friction_speed": MYSTERY.friction_speed},
    ),
    "oscillator": (
        {"oscillator.frequency": CIRCUIT.frequency, "oscillator.quality": CIRCUIT.quality,
         "oscillator.gain": CIRCUIT.gain, "cubic-stiffness.k3": CIRCUIT.cubic},
        ("cubic-stiffness",), {"cubic": "k3 in 1/(V² s²), beside ω0² z"},
    ),
}  # fmt: skip

HEADS: dict[str, tuple[dict[str, object], tuple[str, ...], dict[str, dict[str, object]]]] = {
    "platform_317hz": (
        {"title": "Stressed platform with hysteresis, 8 V at 317 Hz and beside resonance"},
        ("residual-stress", "pzt-hysteresis"), {"residual-stress": {"closure": "axial-force"}},
    ),
    "platform_clean": ({"title": "Linear platform, nothing hidden"}, (), {}),
    "platform_fe": (
        {"title": "Stressed platform, restoring force from finite elements"},
        ("residual-stress",), {"residual-stress": {"closure": "frame"}},
    ),
    "mystery_platform": (
        {"title": "Stressed platform on which something else acts"},
        ("residual-stress",), {"residual-stress": {"closure": "axial-force"}},
    ),
    "oscillator": (
        {"title": "Electronic oscillator in volts", "device": {"kind": "oscillator", "output": "V"}}, (), {},
    ),
}  # fmt: skip


def make(name: str, folder: Path) -> None:
    """Write one campaign, except its PROVENANCE.md, which is kept by hand."""
    folder.mkdir(parents=True, exist_ok=True)
    columns, response_noise, drive_noise = STYLES[name]
    records: list[dict[str, object]] = []
    for index, plan in enumerate(PLANS[name]):
        write_csv(folder / plan.file, columns, record(name, index), comment=f"simulated, {name}")
        entry: dict[str, object] = {"file": plan.file, "kind": "trace", "start": "rest", "holdout": plan.holdout}
        records.append(entry | ({"load": f"{plan.load * 1e6:.0f} mg"} if plan.load else {}))
    head, effects, settings = HEADS[name]
    write_campaign(folder / "campaign.toml", head, effects, settings, records)
    parameters, hidden, notes = TRUTHS[name]
    extra = {"effects": list(hidden), "noise": response_noise, "drive_noise": drive_noise} | notes
    write_truth(folder / "truth.toml", parameters, extra)


def without(stage: Stage, stress: bool = False, hysteresis: bool = False) -> Stage:
    """The stage with mechanisms switched off."""
    stage = replace(stage, closure="none") if stress else stage
    return replace(stage, eta=0.0, zeta=0.0) if hysteresis else stage


if __name__ == "__main__":
    for campaign in PLANS:
        make(campaign, DATA / campaign)
