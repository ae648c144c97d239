"""Devices for `calibration` and `model_choice`: stressed platforms from their prior, by the independent simulator.

Frequency, quality, d31, the stress gradient of the PZT, the drive's axial force and the loop of its hysteresis are
drawn; the rest is held at the truth, for one device's records cannot tell it apart.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from experiments.make_campaigns import PAPER, SIGMA12
from experiments.simulator import noise
from experiments.simulator.signals import sine
from experiments.simulator.stage import Stage, simulate
from ident.campaign import Campaign, Channel, NoiseFloor, Platform, Trace
from ident.campaign.campaign import Prior
from ident.fit import Fit
from ident.fit.fit import fit
from ident.model import build_model

PRIORS = {
    "platform.frequency": Prior(498.6, 5.0),
    "platform.quality": Prior(31.0, 2.0),
    "platform.d31": Prior(64e-12, 4e-12),
    "residual-stress.sigma12": Prior(SIGMA12, 0.4 * SIGMA12),
    "residual-stress.voltage_force": Prior(5e-3, 2e-3),
    "pzt-hysteresis.zeta": Prior(1.7e-23, 0.5e-23),
}
_HELD = {
    "residual-stress.sigma23": PAPER.sigma23,
    "residual-stress.restraint": PAPER.restraint,
    "pzt-hysteresis.eta": PAPER.eta,
}
DRIVES = ((8.0, 317.0), (6.0, 505.0))
SIGMA, PERIODS, POINTS = 0.1e-6, 12, 60


def case(seed: int) -> tuple[dict[str, float], Fit]:
    """True parameters, and the fit of one simulated campaign."""
    random = np.random.default_rng([16, seed])
    truth = draw_truth(random)
    stage = replace(PAPER, **{name.split(".")[1]: value for name, value in truth.items()})
    return truth, fitted(measure(random, stage, SIGMA), ("residual-stress", "pzt-hysteresis"))


def draw_truth(random: np.random.Generator) -> dict[str, float]:
    """Parameters of one device, SI, from `PRIORS`."""
    return {name: float(random.normal(p.mean, p.deviation)) for name, p in PRIORS.items()}


def measure(random: np.random.Generator, stage: Stage, sigma: float) -> tuple[Trace, ...]:
    """A device's records, with white noise of `sigma` m."""
    records = []
    for volts, hertz in DRIVES:
        time, wave = np.arange(PERIODS * POINTS) / (POINTS * hertz), sine(volts, hertz)
        z = simulate(stage, wave, time)[0] + noise.white(random, len(time), sigma)
        floor, channels = NoiseFloor(sigma, (), "given"), (Channel("V", 1.0), Channel("um", 1e-6))
        records.append(Trace(f"{hertz:g} Hz", time, wave.value(time), z, *channels, floor, "rest"))
    return tuple(records)


def fitted(records: tuple[Trace, ...], effects: tuple[str, ...]) -> Fit:
    """The fit of a platform with some of the two effects."""
    held: dict[str, dict[str, object]] = {name: {} for name in effects}
    for name, value in _HELD.items():
        effect, parameter = name.split(".")
        if effect in held:
            own = held[effect]
            own[parameter], own["fixed"] = value, (*own.get("fixed", ()), parameter)  # type: ignore[misc]
    priors = {name: prior for name, prior in PRIORS.items() if name.split(".")[0] in ("platform", *effects)}
    campaign = Campaign("platform", records, Platform(), settings=held, priors=priors)
    model = build_model(campaign, effects)
    start = (*model.start, *((n, p.mean) for n, p in priors.items()))
    return fit(replace(model, start=start), campaign)
