"""An oscillator shaken by its base, with one accelerometer on the base and one on the body, against SciPy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.campaign import Channel, NoiseFloor, Trace
from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.ranking.score import score
from ident.diagnosis.search.change import add
from ident.effects.library.cubic_stiffness import CubicStiffness
from ident.effects.library.sensor_nonlinearity import SensorNonlinearity
from ident.fit import fit
from ident.fit.linear.start_model import start_model
from ident.model import GAIN

F, Q = 25.0, 6.0
OMEGA = 2 * np.pi * F
CUBE = 3e5 * OMEGA**2
"""1/(m² s²), on the distance from the base."""


def shaken(size: float, seed: int, *, cube: float = 0.0, riding: bool = True) -> Trace:
    """A record from rest, the base in random accelerations of some rms size (m/s²); the accelerometer rides on the
    body, or reads the distance between the two."""
    rng, t = np.random.default_rng(seed), np.arange(2000) / (40 * F)
    tones = F * np.arange(0.3, 3.0, 0.1)
    phases = rng.uniform(0, 2 * np.pi, len(tones))

    def base(at: np.ndarray) -> np.ndarray:
        moved = np.sin(2 * np.pi * np.multiply.outer(at, tones) + phases).sum(axis=-1)
        return size * np.sqrt(2 / len(tones)) * np.clip(at * F / 4, 0, 1) ** 2 * moved

    def force(z: np.ndarray, v: np.ndarray) -> np.ndarray:
        return -(OMEGA**2) * z - OMEGA / Q * v - cube * z**3

    rates = lambda at, y: (y[1], force(y[0], y[1]) - base(np.asarray(at)))
    z, v = solve_ivp(rates, (0, t[-1]), (0.0, 0.0), "DOP853", t, rtol=1e-9, atol=1e-14).y
    read = force(z, v) if riding else force(z, v) - base(t)
    noise = 0.01 * float(np.std(read))
    floor = NoiseFloor(noise, (), "given", 0.0)
    unit = Channel("m/s^2", 1.0)
    return Trace(
        "shaker.csv",
        t,
        base(t),
        read + noise * rng.normal(size=len(t)),
        unit,
        unit,
        floor,
        start="rest",
        measures="acceleration",
    )


def campaign(*records: Trace) -> Campaign:
    return Campaign("mount", tuple(records), Oscillator("m", "m/s^2"))


def test_what_its_base_shakes_is_told_from_what_a_force_drives():
    for riding, form in ((True, "shaken"), (False, "oscillator")):
        told = campaign(shaken(3.0, 1, riding=riding), shaken(6.0, 2, riding=riding))
        model = start_model(told)
        found = fit(model, told)
        assert model.form == form
        assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.06)
        assert found["frequency"].value == pytest.approx(F, rel=1e-3)
        assert found["quality"].value == pytest.approx(Q, rel=0.01)
        assert abs(found.values[GAIN]) == pytest.approx(1.0, abs=5e-3)


def test_forces_act_by_the_distance_from_the_base():
    told = campaign(shaken(4.0, 3, cube=CUBE), shaken(12.0, 4, cube=CUBE))
    found = fit(start_model(told) + CubicStiffness(), told)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.06)
    assert found["k3"].value == pytest.approx(CUBE, abs=4 * (found["k3"].error or 0.0))


def test_scores_promise_what_refits_keep():
    told = campaign(shaken(4.0, 5, cube=CUBE), shaken(12.0, 6, cube=CUBE))
    plain = fit(start_model(told), told)
    (spring,) = score(prepare(plain), {"cubic-stiffness": CubicStiffness})
    assert spring.predicted_gain > 0.95
    assert spring.values["k3"] == pytest.approx(CUBE, rel=0.1)


def test_a_sensor_sees_the_motion_of_the_body():
    plain = shaken(5.0, 7)
    bent = 0.02 / np.max(np.abs(plain.response))
    told = campaign(replace(plain, response=plain.response + bent * plain.response**2))
    linear = fit(start_model(told), told)
    (sensor,) = score(prepare(linear), {"sensor-nonlinearity": SensorNonlinearity})
    found = add(linear, SensorNonlinearity)
    assert sensor.predicted_gain > 0.9
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.1)
