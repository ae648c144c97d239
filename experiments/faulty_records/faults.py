"""Thirteen things that go wrong with one record of a campaign, done to a case of the hidden-effect generator.

What a fault needs beyond the measured samples (a later start, another device) is simulated again by the generator.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from experiments.hidden_effects.generator import Case, Device, Made, Plan, hidden_in, respond

FAULTS = (
    "late", "early", "gain", "inverted", "time-scale", "load",
    "device", "drift", "clipped", "spikes", "dropped", "twice", "own-clock",
)  # fmt: skip

EXPECTED = {
    "late": ("delay",), "early": ("delay",), "gain": ("gain",), "inverted": ("sign",), "time-scale": ("time-scale",),
    "load": ("wrong-record", "time-scale"), "device": ("wrong-record", "time-scale"), "drift": ("drift",),
    "clipped": ("clipping",), "spikes": ("spikes",), "dropped": ("delay",), "twice": ("duplicate",),
    "own-clock": ("time-scale",),
}  # fmt: skip
"""Kinds of suspect that name the fault; a resonance that is off is a time scale as well, but for the drive."""


def spoil(case: Case, fault: str, seed: int) -> tuple[list[Made], str]:
    """The records with one fault in one fitted record, and the name of that record."""
    rng = np.random.default_rng([seed, FAULTS.index(fault), 29])
    fitted = [k for k, made in enumerate(case.records) if not made.holdout]
    k = int(rng.choice(fitted))
    records = list(case.records)
    if fault == "twice":
        twin = replace(records[k], name=f"{records[k].name}_again")
        return [*records[: k + 1], twin, *records[k + 1 :]], twin.name
    records[k] = _DO[fault](case, k, rng)
    return records, records[k].name


def _again(case: Case, k: int, rng: np.random.Generator, more: int, device: Device | None = None) -> np.ndarray:
    """The response of a record simulated once more, with `more` samples at its end and fresh noise."""
    plan, made = case.plans[k], case.records[k]
    step = plan.t[1] - plan.t[0]
    longer = Plan(plan.name, plan.drive, plan.t[0] + step * np.arange(len(plan.t) + more), plan.lead, plan.holdout)
    thing = device or case.device
    y, _, _ = respond(longer, thing, *hidden_in(case), 8)
    return y * thing.unit + made.sigma * rng.standard_normal(len(y))


def _late(case: Case, k: int, rng: np.random.Generator) -> Made:
    made, delay = case.records[k], int(rng.integers(3, 20))
    before = made.sigma * rng.standard_normal(delay)
    return replace(made, response=np.concatenate([before, made.response[:-delay]]))


def _early(case: Case, k: int, rng: np.random.Generator) -> Made:
    made, delay = case.records[k], int(rng.integers(3, 20))
    return replace(made, response=_again(case, k, rng, delay)[delay:])


def _gain(case: Case, k: int, rng: np.random.Generator) -> Made:
    made = case.records[k]
    return replace(made, drive=made.drive * float(rng.choice([0.1, 0.5, 0.9, 1.1, 2.0, 10.0])))


def _inverted(case: Case, k: int, rng: np.random.Generator) -> Made:
    return replace(case.records[k], response=-case.records[k].response)


def _time_scale(case: Case, k: int, rng: np.random.Generator) -> Made:
    made = case.records[k]
    return replace(made, time=made.time * float(rng.choice([0.5, 0.95, 1.05, 2.0])))


def _load(case: Case, k: int, rng: np.random.Generator) -> Made:
    made, ratio = case.records[k], float(rng.uniform(0.85, 0.95))
    heavier = replace(case.device, frequency=case.device.frequency * ratio, gain=case.device.gain)
    return replace(made, response=_again(case, k, rng, 0, heavier))


def _device(case: Case, k: int, rng: np.random.Generator) -> Made:
    made, thing = case.records[k], case.device
    other = replace(
        thing, frequency=thing.frequency * float(rng.uniform(1.04, 1.15)),
        quality=thing.quality * rng.uniform(0.5, 0.8), gain=thing.gain * rng.uniform(0.7, 1.4),
    )  # fmt: skip
    return replace(made, response=_again(case, k, rng, 0, other))


def _drift(case: Case, k: int, rng: np.random.Generator) -> Made:
    made = case.records[k]
    ramp = np.linspace(0.0, 1.0, len(made.response)) ** rng.uniform(0.7, 1.5)
    return replace(made, response=made.response + 0.3 * np.ptp(made.clean) * ramp)


def _clipped(case: Case, k: int, rng: np.random.Generator) -> Made:
    made = case.records[k]
    limit = float(rng.uniform(0.5, 0.9)) * float(np.max(np.abs(made.clean)))
    return replace(made, response=np.clip(made.response, -limit, limit))


def _spikes(case: Case, k: int, rng: np.random.Generator) -> Made:
    made = case.records[k]
    response = made.response.copy()
    places = rng.choice(np.arange(50, len(response) - 50), int(rng.integers(1, 8)), replace=False)
    response[places] += rng.choice([-1.0, 1.0], len(places)) * rng.uniform(0.5, 2.0, len(places)) * np.std(made.clean)
    return replace(made, response=response)


def _dropped(case: Case, k: int, rng: np.random.Generator) -> Made:
    """Some samples are missing from the response, but their times are not."""
    made, lost = case.records[k], int(rng.integers(5, 40))
    longer, n = _again(case, k, rng, lost), len(made.response)
    at = int(rng.integers(n // 3, 2 * n // 3))
    return replace(made, response=np.concatenate([longer[:at], longer[at + lost :]]))


def _own_clock(case: Case, k: int, rng: np.random.Generator) -> Made:
    """The response was taken by another instrument, whose clock runs faster than that of the drive."""
    made, scale = case.records[k], 1.0 + float(rng.uniform(1e-3, 1.9e-3))
    n = len(made.response)
    clean = CubicSpline(np.arange(n + 8), _again(replace(case, records=_silent(case)), k, rng, 8))
    response = clean(scale * np.arange(n)) + made.sigma * rng.standard_normal(n)
    return replace(made, response=response)


def _silent(case: Case) -> list[Made]:
    return [replace(made, sigma=0.0) for made in case.records]


_DO: dict[str, Callable[[Case, int, np.random.Generator], Made]] = {
    "late": _late, "early": _early, "gain": _gain, "inverted": _inverted, "time-scale": _time_scale, "load": _load,
    "device": _device, "drift": _drift, "clipped": _clipped, "spikes": _spikes, "dropped": _dropped,
    "own-clock": _own_clock,
}  # fmt: skip
