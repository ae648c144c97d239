"""Devices for `calibration`: stressed platforms from their prior, simulated by `experiments.simulator`.

Frequency, quality, d31, the stress gradient of the PZT, the drive's axial force and the loop of its hysteresis are
drawn; the rest is held at the truth, for one device's records cannot tell it apart.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from experiments.make_campaigns import PAPER, SIGMA12
from experiments.simulator import noise
from experiments.simulator.signals import sine
from experiments.simulator.stage import simulate
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
    truth = {name: float(random.normal(p.mean, p.deviation)) for name, p in PRIORS.items()}
    stage = replace(PAPER, **{name.split(".")[1]: value for name, value in truth.items()})
    records = []
    for volts, hertz in DRIVES:
        time, wave = np.arange(PERIODS * POINTS) / (POINTS * hertz), sine(volts, hertz)
        z = simulate(stage, wave, time)[0] + noise.white(random, len(time), SIGMA)
        floor, channels = NoiseFloor(SIGMA, (), "given"), (Channel("V", 1.0), Channel("um", 1e-6))
        records.append(Trace(f"{hertz:g} Hz", time, wave.value(time), z, *channels, floor, "rest"))
    fixed: dict[str, dict[str, object]] = {"residual-stress": {}, "pzt-hysteresis": {}}
    for name, value in _HELD.items():
        effect, parameter = name.split(".")
        own = fixed[effect]
        own[parameter], own["fixed"] = value, (*own.get("fixed", ()), parameter)  # type: ignore[misc]
    campaign = Campaign("calibration", tuple(records), Platform(), settings=fixed, priors=PRIORS)
    model = build_model(campaign, ("residual-stress", "pzt-hysteresis"))
    start = (*model.start, *((n, p.mean) for n, p in PRIORS.items()))
    return truth, fit(replace(model, start=start), campaign)
