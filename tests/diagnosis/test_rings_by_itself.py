"""Records of one frequency, which a resonance there follows whatever drove them: their agreement is no evidence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ident.campaign import Campaign, Trace
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor
from ident.diagnosis.faulty.faults import Fault, residual_of, rings_by_itself
from ident.diagnosis.faulty.nuisance import Nuisance
from ident.fit.minimise import minimise
from ident.fit.solve import How
from ident.model import build_model

_NOISE = 0.002


def _damper(size: float) -> Trace:
    """A damper in a test machine: a sine of 1 Hz is imposed, and the force holds a dry friction."""
    t = np.arange(400) / 100.0
    z, v = size * np.sin(2 * np.pi * t), 2 * np.pi * size * np.cos(2 * np.pi * t)
    force = z + 0.8 * np.tanh(v / 0.3) + 0.1 * v
    noise = _NOISE * np.random.default_rng(int(100 * size)).standard_normal(len(t))
    volts = Channel("N", 1.0)
    return Trace(f"{size}.csv", t, force, z + noise, volts, volts, NoiseFloor(_NOISE), start="unknown")


def _device(size: float) -> Trace:
    """The same sines as an answer to what drove them: a spring and a damper."""
    record = _damper(size)
    return replace(record, drive=record.response + 0.3 * np.gradient(record.response, record.step))


def _fault(records: tuple[Trace, ...], start: tuple[float, float, float]) -> Fault:
    campaign = Campaign("test", records, Oscillator("m", "N"), linear="oscillator")
    found = minimise(build_model(campaign), campaign, How(most=60), initial=np.array(start))
    left, worst = residual_of(found, campaign)
    told = Nuisance("time-scale", 2.0, "1", worst)
    return Fault(2, told, campaign, found.values, left, 4, worst)


def test_a_fault_that_leaves_records_of_one_frequency_to_a_ringing_is_none():
    sizes = (0.2, 0.5, 1.0)
    ringing = _fault(tuple(_damper(size) for size in sizes), (1.0, 1e4, 1e-3))
    assert ringing.worst < 1.3  # all of it is explained, and nothing of it by the force
    assert rings_by_itself(build_model(ringing.campaign), ringing)
    driven = _fault(tuple(_device(size) for size in sizes), (0.6, 0.2, 15.0))
    assert not rings_by_itself(build_model(driven.campaign), driven)
    steady = tuple(replace(record, start="steady") for record in ringing.campaign.fitted)
    begun = ringing._replace(campaign=replace(ringing.campaign, records=steady))
    assert not rings_by_itself(build_model(begun.campaign), begun)
