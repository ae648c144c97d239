"""Hidden effects: `draw` makes a campaign in memory, `write` puts it in a folder and its truth elsewhere."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np

from experiments.simulator import noise as noises
from experiments.simulator.files import Column, write_campaign, write_csv
from experiments.simulator.geometry import Geometry
from experiments.simulator.signals import Chirp, Drive, multisine, reference_rate, sine

from .laws import INDEX, LAWS, STATES, driven, march, sensed
from .linear import Sampled, misfit

SAMPLES_PER_PERIOD = 80  # of the natural frequency
SUBSTEPS = 8
NoiseKind = Literal["white", "ar", "hum"]
Starts = Literal["rest", "mixed", "steady"]
SETTLED = 5.0  # times the quality, in periods: of the switching-on 2e-7 is left then


@dataclass(frozen=True)
class Device:
    """A device: natural frequency (Hz), quality, gain, and units of displacement, drive and time.

    `unit` is the displacement (m or V) and `volts` the drive (V) that the dimensionless laws count in; `span` the time
    (s) that drifts count in, the length of the records with which it was drawn.
    """

    kind: Literal["platform", "oscillator"]
    frequency: float
    quality: float
    gain: float
    unit: float
    volts: float
    span: float

    @cached_property
    def geometry(self) -> np.ndarray:
        """Constants of the stressed beams, for `laws.force`."""
        g = Geometry()
        rise = g.initial_shape(g.residual_moment(1.0, 0.0, -17.0 / 30.0))
        a = g.frame_stiffness()
        return np.array([self.unit, *g.shares, *rise, g.length_1, g.length_2, g.bending, *g.corner_ratios,
                         a[0, 0], a[0, 1], a[1, 1], g.stage_stiffness])  # fmt: skip

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of the linear part, SI, named as the tool names them."""
        g, w0 = Geometry(), 2 * np.pi * self.frequency
        slope = self.gain * self.unit / self.volts  # static displacement per volt
        if self.kind == "oscillator":
            names = {"oscillator.frequency": self.frequency, "oscillator.quality": self.quality}
            return names | {"oscillator.gain": slope * w0**2}
        d31 = slope * g.stage_mass * w0**2 * g.pzt_thickness / g.drive_gain
        return {"platform.frequency": self.frequency, "platform.quality": self.quality, "platform.d31": d31}


@dataclass(frozen=True)
class Plan:
    """One record to take: drive (volts, Hz), times (s), whether it starts from rest and whether it is held out."""

    name: str
    drive: Drive
    t: np.ndarray
    lead: int  # samples before the first one kept: the record starts in the middle of a motion
    holdout: bool
    steady: bool = False  # whether nothing is left of the switching-on by then


@dataclass(frozen=True, eq=False)
class Made:
    """One record: SI columns as measured, standard deviation of the noise, and the response without noise."""

    name: str
    time: np.ndarray
    drive: np.ndarray
    response: np.ndarray
    clean: np.ndarray
    sigma: float
    start: Literal["rest", "steady", "unknown"]
    holdout: bool
    measures: Literal["displacement", "velocity", "acceleration"] = "displacement"


@dataclass(frozen=True, eq=False)
class Case:
    """A campaign in memory, what it was played, and what is true about it."""

    device: Device
    plans: list[Plan]
    records: list[Made]
    truth: dict[str, object]


def plan_records(rng: np.random.Generator, device: Device, records: int, starts: Starts, length: int) -> list[Plan]:
    f0, full = device.frequency, device.volts
    dt = 1 / (SAMPLES_PER_PERIOD * f0)
    # From well below to above resonance, weak and strong, so that no law can hide behind another's frequency or level.
    ratios = [rng.uniform(0.4, 0.7), rng.uniform(0.9, 0.97), rng.uniform(0.98, 1.02), rng.uniform(1.06, 1.12)]
    ratios += list(rng.uniform(0.4, 1.12, max(records - 4, 0)))
    levels = np.linspace(1 / 3, 1, records)[rng.permutation(records)]
    levels[2] = 1.0
    drives: list[tuple[str, Drive, bool]] = [
        (f"sine_{k}_{level * full:.2g}V_{ratio * f0:.0f}Hz", sine(level * full, ratio * f0), False)
        for k, (ratio, level) in enumerate(zip(ratios[:records], levels, strict=True))
    ]
    spacing = 1 / (length * dt)
    tones = np.arange(np.ceil(0.2 * f0 / spacing), 1.2 * f0 / spacing) * spacing
    flat = multisine(1.0, np.arange(1.0, len(tones) + 1), int(rng.integers(1 << 31)))
    broad = type(flat)(flat.amplitudes * full * 0.8, tones, flat.phases)
    drives += [
        ("new_level", sine(rng.uniform(0.5, 0.95) * full, rng.uniform(0.95, 1.03) * f0), True),
        ("new_frequency", sine(rng.uniform(0.4, 0.9) * full, rng.uniform(0.72, 0.88) * f0), True),
        ("multisine", broad, True),
        ("chirp", Chirp(0.7 * full, 0.5 * f0, 1.2 * f0, length * dt), True),
    ]
    plans = []
    for name, drive, holdout in drives:
        periodic = isinstance(drive, type(flat))
        lead = int(rng.integers(80, 800)) if starts == "mixed" and periodic and rng.random() < 0.5 else 0
        settled = starts == "steady" and periodic
        if settled:
            lead = int(SETTLED * device.quality * SAMPLES_PER_PERIOD + rng.integers(0, SAMPLES_PER_PERIOD))
        plans.append(Plan(name, drive, (np.arange(length + lead) - lead) * dt, lead, holdout, settled))
    return plans


def respond(
    plan: Plan, device: Device, c: np.ndarray, s: np.ndarray, substeps: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Dimensionless response and displacement at the kept samples, and the kept drive on the half-step grid."""
    w0 = 2 * np.pi * device.frequency
    fine = np.linspace(plan.t[0], plan.t[-1], 2 * substeps * (len(plan.t) - 1) + 1)
    e, de = plan.drive.value(fine) / device.volts, plan.drive.rate(fine) / device.volts
    kept, span = plan.t[plan.lead :], device.span
    step = w0 * (fine[2] - fine[0])
    u = device.gain * driven(e, de, reference_rate(plan.drive, kept), step / 2, c, s)
    geometry, start = device.geometry, plan.t[0] / span
    z, _, m = march(np.zeros(STATES), u, e, step, substeps, start, w0 * span, c, s, geometry, device.quality)
    y = sensed(z, m, e[::2], fine[::2] / span, step, c, s)
    first = plan.lead * substeps
    return y[first::substeps], z[first::substeps], e[2 * first :]


def _relative_misfit(plans: list[Plan], device: Device, c: np.ndarray, s: np.ndarray, substeps: int) -> float:
    """Misfit of the best linear oscillator to the fitted records, as a fraction of the signal.

    Infinite where the effect leaves less than a quarter of the linear motion: that is another device, not an effect.
    """
    w0, sampled, peak = 2 * np.pi * device.frequency, [], 0.0
    for plan in plans:
        if not plan.holdout:
            y, z, e = respond(plan, device, c, s, substeps)
            sampled.append(Sampled(e, y, w0 * (plan.t[1] - plan.t[0]) / substeps, substeps, plan.lead == 0))
            peak = max(peak, float(np.max(np.abs(z))))
    return misfit(sampled)[0] if peak > 0.25 else np.inf


def _coefficient(plans: list[Plan], device: Device, name: str, s: np.ndarray, size: float) -> tuple[float, float]:
    """The coefficient at which the misfit is closest to `size`, and that misfit.

    The misfit grows about linearly, so the coefficient is multiplied until it fits. Some effects cannot get there.
    """
    c, value = np.zeros(len(LAWS)), 0.03
    tried: list[tuple[float, float, float]] = []
    for _ in range(14):
        c[INDEX[name]] = value
        now = _relative_misfit(plans, device, c, s, 2)
        tried.append((abs(np.log(max(now, 1e-12) / size)) if np.isfinite(now) else np.inf, value, now))
        if tried[-1][0] < 0.02:
            break
        value *= float(np.clip(size / max(now, 1e-12), 0.2, 8.0)) if np.isfinite(now) else 0.3
    return min(tried)[1:]


def _device(
    rng: np.random.Generator, kind: Literal["platform", "oscillator"], length: int, within: tuple[float, float] | None
) -> Device:
    quality = rng.uniform(20, 60) if within is None else float(np.exp(rng.uniform(*np.log(within))))
    if kind == "platform":
        frequency, unit, volts = rng.uniform(450, 550), rng.uniform(8e-6, 30e-6), 9.0
    else:
        frequency, unit, volts = 10 ** rng.uniform(0.7, 3.7), 10 ** rng.uniform(-2, 1), 10 ** rng.uniform(-1, 1)
    return Device(kind, frequency, quality, 1.0, unit, volts, (length - 1) / (SAMPLES_PER_PERIOD * frequency))


def draw(
    seed: int,
    effects: tuple[str, ...],
    *,
    size: float = 0.02,
    noise: float = 0.003,
    noise_kind: NoiseKind = "white",
    drive_noise: float = 0.0,
    device: Literal["platform", "oscillator"] = "platform",
    starts: Starts = "rest",
    detail: Literal["own", "plain"] = "own",
    records: int = 6,
    length: int = 1600,
    quality: tuple[float, float] | None = None,
    shapes: Mapping[str, tuple[float, float, float]] | None = None,
) -> Case:
    """One device with hidden effects, simulated.

    **Arguments:**

    - `effects`: names from `laws.NAMES`; () is a device with nothing hidden.
    - `size`: misfit that each effect alone gives the best linear oscillator, as a fraction of the rms signal.
    - `noise`: noise as a fraction of each record's rms signal; `noise_kind`: white, autoregressive (0.9), or mains hum.
    - `drive_noise`: white noise of the drive column as a fraction of the largest drive.
    - `starts`: all records from rest, or about half cut out of a running motion ("unknown"), or all of a periodic drive
      cut out of a motion that has settled.
    - `detail`: force laws of the study's own, or those of the textbook.
    - `records`: fitted sines (at least 4); `length`: samples in each, at 80 per natural period.
    - `quality`: between which two it is drawn, all powers of ten alike, instead of 20 and 60.
    - `shapes`: fixed shape numbers of an effect instead of drawn ones.
    """
    if device == "oscillator" and {"residual-stress", "arch-force"} & set(effects):
        raise ValueError("Stressed beams belong to a platform.")
    rng = np.random.default_rng([seed, 7])
    thing = _device(rng, device, length, quality)
    plans = plan_records(rng, thing, records, starts, length)
    c, s = np.zeros(len(LAWS)), np.zeros((len(LAWS), 3))
    linear = max(np.max(np.abs(respond(p, thing, c, s, 2)[1])) for p in plans if not p.holdout)
    thing = replace(thing, gain=1 / linear)
    for name in effects:
        s[INDEX[name]] = shapes[name] if shapes and name in shapes else LAWS[INDEX[name]].shape(rng, detail == "own")
    alone = {name: _coefficient(plans, thing, name, s, size) for name in effects}
    for name, (coefficient, _) in alone.items():
        c[INDEX[name]] = coefficient
    made = [_measure(rng, plan, thing, c, s, noise, noise_kind, drive_noise) for plan in plans]
    truth: dict[str, object] = {
        "effects": list(effects),
        "laws": {n: {"side": LAWS[i].side, "coordinates": list(LAWS[i].coordinates), "in_library": LAWS[i].in_library,
                     "alike": list(LAWS[i].alike), "size": alone[n][1], "coefficient": c[i], "shape": list(s[i])}
                 for n in effects for i in [INDEX[n]]},
        "size": _relative_misfit(plans, thing, c, s, 2) if len(effects) != 1 else alone[effects[0]][1],
        "noise": noise, "noise_kind": noise_kind, "drive_noise": drive_noise, "detail": detail, "seed": seed,
        "device": thing.kind, "parameters": thing.parameters,
        "sigma": {m.name: m.sigma for m in made}, "unit": thing.unit, "volts": thing.volts,
    }  # fmt: skip
    return Case(thing, plans, made, truth)


def _measure(
    rng: np.random.Generator, plan: Plan, device: Device, c: np.ndarray, s: np.ndarray,
    noise: float, kind: NoiseKind, drive_noise: float,
) -> Made:  # fmt: skip
    y, _, _ = respond(plan, device, c, s, SUBSTEPS)
    if not np.all(np.isfinite(y)):
        raise ValueError(f"The motion of record {plan.name} has no bound; draw another device.")
    clean, t = y * device.unit, plan.t[plan.lead :]
    sigma, n = noise * float(np.std(clean)), len(t)
    if kind == "white":
        error = noises.white(rng, n, sigma)
    elif kind == "ar":
        error = noises.autoregressive(rng, n, sigma, 0.9)
    else:
        error = noises.hum(rng, t, sigma, mains=50.0 if device.kind == "platform" else 0.1 * device.frequency)
    drive = plan.drive.value(t) + noises.white(rng, n, drive_noise * device.volts)
    start = "steady" if plan.steady else "unknown" if plan.lead else "rest"
    return Made(plan.name, t, drive, clean + error, clean, sigma, start, plan.holdout)


def hidden_in(case: Case) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients (laws,) and shape numbers (laws, 3) of a case's hidden effects."""
    c, s = np.zeros(len(LAWS)), np.zeros((len(LAWS), 3))
    for effect, law in case.truth["laws"].items():  # type: ignore[union-attr]
        c[INDEX[effect]], s[INDEX[effect]] = law["coefficient"], law["shape"]
    return c, s


def measure_again(case: Case, name: str, drive: Drive, time: np.ndarray) -> Made:
    """One more record of a case's device, from rest, with the noise that its other records have."""
    c, s = hidden_in(case)
    rng = np.random.default_rng([int(case.truth["seed"]), 13])  # type: ignore[call-overload]
    plan = Plan(name, drive, time, 0, False)
    return _measure(rng, plan, case.device, c, s, float(case.truth["noise"]), "white", 0.0)  # type: ignore[arg-type]


def _decimals(smallest: float) -> int:
    """Decimals that keep the rounding well below `smallest`."""
    return max(0, int(np.ceil(-np.log10(smallest))) + 1)


def write(case: Case, folder: Path, truth: Path, effects: tuple[str, ...] = ()) -> None:
    """Write the campaign to `folder` and what is true to the file `truth`, which should lie elsewhere."""
    folder.mkdir(parents=True, exist_ok=True)
    platform = case.device.kind == "platform"
    response = ("z_um", 1e6) if platform else ("y_mV", 1e3)
    records: list[dict[str, object]] = []
    for made in case.records:
        dt = float(made.time[1] - made.time[0])
        least = max(made.sigma, 1e-6 * float(np.std(made.clean)))
        columns = (
            Column("t_ms", 1e3, _decimals(dt * 1e3 * 1e-5)),
            Column("u_V", 1.0, _decimals(case.device.volts * 1e-6)),
            Column(response[0], response[1], _decimals(least * response[1] * 0.1)),
        )
        write_csv(folder / f"{made.name}.csv", columns, (made.time, made.drive, made.response))
        records.append({"file": f"{made.name}.csv", "kind": "trace", "start": made.start, "holdout": made.holdout})
    head: dict[str, object] = {"title": "A device with something hidden"}
    if not platform:
        head["device"] = {"kind": "oscillator", "output": "V"}
    write_campaign(folder / "campaign.toml", head, effects, {}, records)
    truth.parent.mkdir(parents=True, exist_ok=True)
    truth.write_text(json.dumps(case.truth, indent=1) + "\n", encoding="utf-8")
