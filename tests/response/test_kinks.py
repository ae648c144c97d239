"""Steps that meet a kink are divided: against SciPy, which goes from kink to kink."""

import math

import numpy as np
import pytest

from experiments.convergence.kinks import HERTZ, OMEGA, QUALITY, SIGMA, TRUTH, model, record
from ident.campaign.device import Oscillator
from ident.model import COARSE, Model
from ident.response import Equation, divided, lay_out, respond

EFFECTS = pytest.mark.parametrize("effect", sorted(TRUTH))


@EFFECTS
def test_it_follows_a_kink_within_a_fifth_of_the_noise(effect):
    trace = record()
    system, values = model(effect)
    tape = lay_out([trace], HERTZ, QUALITY, system)
    found = respond(Equation(system), tape, values, np.zeros((1, 2))).readings
    wanted = TRUTH[effect](trace.time)
    missed = np.max(np.abs(found - wanted))
    assert missed < 0.2 * SIGMA  # the friction turns over a little velocity, not at once
    whole = divided([trace], [tape.spans[0].substeps], np.inf)
    undivided = respond(Equation(system), whole, values, np.zeros((1, 2))).readings
    assert np.max(np.abs(undivided - wanted)) > 3 * missed


@EFFECTS
def test_no_more_steps_than_a_smooth_law_needs(effect):
    trace = record(3e-3)
    pair = Model(Oscillator()), model(effect)[0]
    plain, steps = (lay_out([trace], HERTZ, QUALITY, one).spans[0].substeps for one in pair)
    assert steps == max(plain, math.ceil(COARSE / 40))


@EFFECTS
def test_derivatives_go_with_the_divided_steps(effect):
    trace = record()
    system, values = model(effect)
    if effect == "coulomb-friction":
        values[4] = 0.02  # a sign that turns within a few steps has a derivative that they can follow
    tape, still = lay_out([trace], HERTZ, QUALITY, system), np.zeros((1, 2))
    directions = 1e-3 * np.diag(values)[:4]
    slopes = respond(Equation(system), tape, values, still, directions, np.zeros((4, 1, 2))).slopes
    for along, slope in zip(directions, slopes, strict=True):
        ahead, behind = (respond(Equation(system), tape, values + s * along, still).readings for s in (1, -1))
        apart = slope - (ahead - behind) / 2
        assert np.max(np.abs(apart)) < 0.06 * np.max(np.abs(slope))


def test_a_reading_of_the_velocity_divides_by_its_own_noise():
    system, values = model("coulomb-friction")
    found = []
    for measures, sigma in (("displacement", SIGMA), ("velocity", SIGMA * OMEGA)):
        tape = lay_out([record(sigma, measures)], HERTZ, QUALITY, system)
        found.append(respond(Equation(system), tape, values, np.zeros((1, 2))).z)
    np.testing.assert_allclose(found[0], found[1], atol=0.3 * SIGMA)
