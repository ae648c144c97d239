"""Models are compared in long solver steps; the last search of a fit goes in the short ones that its numbers need."""

from __future__ import annotations

import numpy as np

from ident.campaign import Campaign, Channel, NoiseFloor, Oscillator, Trace
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.linear.independent import independent_samples
from ident.fit.minimise import minimise, refit
from ident.fit.reading import read
from ident.fit.solve import MAX_STEPS, How
from ident.model import Model
from ident.response import steps_of

HERTZ, QUALITY, SAMPLES = 20.0, 200.0, 6000
VALUES = np.array([HERTZ, QUALITY, 3.0])


def campaign(cubic: float = 0.0) -> Campaign:
    """Two tones about the resonance of a high quality, read with 0.1 % of noise: in the model's own finest steps."""
    t = np.arange(SAMPLES) / 640.0
    drive = np.cos(2 * np.pi * 19.7 * t) + np.cos(2 * np.pi * 20.3 * t + 1.0)
    channel = Channel("V", 1.0)
    record = Trace("two tones.csv", t, drive, np.ones_like(t), channel, channel, noise=NoiseFloor(1e-9), start="rest")
    model = Model(Oscillator(), (built_in()["cubic-stiffness"](),))
    read_off = read(model, np.append(VALUES, [cubic, 0.0]), [record])[0]
    sigma = 1e-3 * float(np.std(read_off))
    noisy = read_off + np.random.default_rng(7).normal(0.0, sigma, SAMPLES)
    told = Trace("two tones.csv", t, drive, noisy, channel, channel, noise=NoiseFloor(sigma), start="rest")
    return Campaign("two tones", (told,), Oscillator())


def test_a_fit_ends_in_short_steps_at_the_true_frequency():
    records = campaign()
    [record] = records.fitted
    found = fit(Model(Oscillator()), records)
    short = steps_of(record, HERTZ, QUALITY, 0)
    long = steps_of(record, HERTZ, QUALITY, 0, compared=True)
    assert long < short
    assert found.solved.data.tape.spans[0].substeps == short
    assert abs(found["frequency"].value - HERTZ) < 4 * (found["frequency"].error or 0.0)
    assert found.converged and found.step_error < 0.1


def test_a_comparison_ends_by_its_independent_samples():
    """Far above the noise a fall of the cost counts in what is left, which is as smooth as the motion."""
    records = campaign(cubic=2e7)
    compared = refit(Model(Oscillator()), records, None, MAX_STEPS)
    ended = minimise(Model(Oscillator()), records, How())
    left = compared.best.found.residuals
    assert independent_samples(left) < 0.1 * SAMPLES
    assert compared.best.steps <= ended.best.steps
    assert compared.best.cost < ended.best.cost * (1 + 0.2 / independent_samples(left))
