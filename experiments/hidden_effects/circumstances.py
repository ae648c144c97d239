"""What other laboratories do differently: the same hidden effects in devices and records that are not the study's usual
ones. Nothing of it is told to the tool but what a column measures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lsim

from .generator import Case, Made, draw
from .laws import INDEX, LAWS

QUALITIES = (0.3, 2000.0)
RATIOS = (0.3, 6.0)  # of the natural frequencies of a further mode and of the first
BESIDE = 0.05  # of it: nearer modes are one resonance to records of twenty periods


def oscillator(seed: int, effects: tuple[str, ...], **told: Any) -> Case:
    """No platform: any frequency, displacements and drives of any size, in volts."""
    return draw(seed, effects, device="oscillator", **told)


def any_quality(seed: int, effects: tuple[str, ...], **told: Any) -> Case:
    """An oscillator, overdamped or ringing on long after the record has ended."""
    return draw(seed, effects, device="oscillator", quality=QUALITIES, **told)


def offset(seed: int, effects: tuple[str, ...], **told: Any) -> Case:
    """An oscillator whose sensor's zero is anywhere within its range."""
    case = oscillator(seed, effects, **told)
    rng = np.random.default_rng([seed, 17])
    shift = rng.uniform(-2.0, 2.0) * max(float(np.std(made.clean)) for made in case.records)
    moved = [replace(made, response=made.response + shift, clean=made.clean + shift) for made in case.records]
    return replace(case, records=moved)


def further_mode(seed: int, effects: tuple[str, ...], **told: Any) -> Case:
    """A linear mode beside the one in which the effect acts: it answers the drive, and the sensor sees both."""
    case = oscillator(seed, effects, **told)
    rng = np.random.default_rng([seed, 19])
    ratio = 1.0
    while abs(ratio - 1.0) < BESIDE:
        ratio = float(np.exp(rng.uniform(*np.log(RATIOS))))
    omega, quality = 2 * np.pi * ratio * case.device.frequency, rng.uniform(20, 60)
    answers = [_mode(made, omega, quality) for made in case.records]
    share = rng.uniform(0.2, 0.6) * rng.choice([-1, 1])
    gain = share * max(float(np.std(m.clean)) for m in case.records) / max(float(np.std(a)) for a in answers)
    both = zip(case.records, (gain * answer for answer in answers), strict=True)
    return replace(case, records=[replace(m, response=m.response + a, clean=m.clean + a) for m, a in both])


def _mode(made: Made, omega: float, quality: float) -> np.ndarray:
    """ẍ + (ω/Q) ẋ + ω² x = ω² V from rest, exact for a drive that is straight between the samples."""
    return lsim(([omega**2], [1.0, omega / quality, omega**2]), made.drive, made.time - made.time[0])[1]


def coloured(seed: int, effects: tuple[str, ...], **told: Any) -> Case:
    """A platform under noise of one colour, or mains hum."""
    return draw(seed, effects, noise_kind="ar" if seed % 2 else "hum", **told)


def two_records(seed: int, effects: tuple[str, ...], **told: Any) -> Case:
    """A platform of which a strong sine near its resonance and a multisine are known, and a chirp to judge by."""
    return _two_of(draw(seed, effects, **told))


def _two_of(case: Case) -> Case:
    near, broad, chirp = case.records[2], case.records[-2], case.records[-1]
    return replace(case, records=[near, replace(broad, holdout=False), chirp])


def three_records(seed: int, effects: tuple[str, ...], **told: Any) -> Case:
    """The same, and a sine well below the resonance."""
    case, fewer = draw(seed, effects, **told), two_records(seed, effects, **told)
    return replace(fewer, records=[case.records[0], *fewer.records])


LONG = 30_000  # samples: minutes at a slow device, and more than are simulated whole before the last fit


def long_records(seed: int, effects: tuple[str, ...], **told: Any) -> Case:
    """An oscillator in two long records, a strong sine near its resonance and a multisine, and a chirp to judge by:
    what drifts does so over the whole of each."""
    return _two_of(oscillator(seed, effects, length=LONG, **told))


def velocity(seed: int, effects: tuple[str, ...], **told: Any) -> Case:
    """An oscillator read by a vibrometer."""
    return _derived(oscillator(seed, effects, **told), "velocity")


def acceleration(seed: int, effects: tuple[str, ...], **told: Any) -> Case:
    """An oscillator that carries an accelerometer."""
    return _derived(oscillator(seed, effects, **told), "acceleration")


def _derived(case: Case, measures: Literal["velocity", "acceleration"]) -> Case:
    """The records of a case as a sensor of the derivative reads them, with as much noise for its signal."""
    rng, found = np.random.default_rng([int(str(case.truth["seed"])), 23]), []
    for made in case.records:
        clean = made.clean
        for _ in range(
            1 if measures == "velocity" else 2
        ):  # each time by a spline of its own, whose slopes at the samples are right to (ω Δt)⁴
            clean = CubicSpline(made.time, clean).derivative()(made.time)
        sigma = float(str(case.truth["noise"])) * float(np.std(clean))
        response = clean + sigma * rng.standard_normal(len(clean))
        found.append(replace(made, response=response, clean=clean, sigma=sigma, measures=measures))
    return replace(case, records=found)


CIRCUMSTANCES: dict[str, Callable[..., Case]] = {
    made.__name__: made
    for made in (oscillator, any_quality, offset, further_mode, coloured, two_records, three_records, long_records,
                 velocity, acceleration)
}  # fmt: skip


def can_show(circumstance: str, effect: str) -> bool:
    """Whether an effect exists there at all: stressed beams belong to platforms, an offset that everything has is no
    effect, nor a mode beside another one, and what a sensor of displacements adds is not what one of velocities
    does."""
    platform = circumstance in ("coloured", "two_records", "three_records")
    if effect in ("residual-stress", "arch-force", "electrostatic-force") and not platform:
        return False
    if circumstance in ("velocity", "acceleration", "offset") and effect in ("static-force", "sensor-offset"):
        return False
    if circumstance in ("velocity", "acceleration") and LAWS[INDEX[effect]].side == "sensor":
        return False
    return not (circumstance == "further_mode" and effect == "second-mode")
