"""Memories in records that begin in motion: their hidden states at the first sample are found, not taken to be at rest.

The devices are simulated by SciPy, long before the first sample that is kept.
"""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.drive import half_step_drive
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.linearised.histories import histories
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.ranking.score import score
from ident.effects.registry import built_in
from ident.fit import fit, rebuild
from ident.fit.problem import evaluate
from ident.fit.rebuild import fit_at
from ident.model import Model
from ident.report.run_json import run_dict
from ident.report.run_state import rebuild_in, state
from ident.response import Equation, respond
from ident.response.lane import Lane
from ident.response.tape import lay

ONE, STEP, SIGMA = Channel("V", 1.0), 5e-4, 2e-3
FREQUENCY, QUALITY, GAIN, SOFT, TIME = 40.0, 25.0, 5e4, 1.5e3, 0.02
OMEGA = 2 * np.pi * FREQUENCY
LIBRARY = built_in()


def waveform(seed: int):
    rng = np.random.default_rng(seed)
    tones = [(rng.uniform(0, 2 * np.pi), 2 * np.pi * f) for f in rng.uniform(15, 60, 6)]
    return lambda t: sum(np.sin(w * t + phase) for phase, w in tones)


def record(seed: int, lead: float, samples: int = 800) -> Trace:
    """A stage with one Maxwell element beside its spring, cut out of a motion that has lasted for `lead` seconds."""
    drive = waveform(seed)

    def rates(t: float, y: np.ndarray) -> list[float]:
        z, v, q = y
        return [v, GAIN * drive(t) - OMEGA**2 * z - OMEGA / QUALITY * v - SOFT * (z - q), (z - q) / TIME]

    t = STEP * np.arange(samples)
    found = solve_ivp(rates, (-lead, t[-1]), [0.0, 0.0, 0.0], t_eval=t, rtol=1e-9, atol=1e-11, max_step=1e-3).y[0]
    noisy = found + SIGMA * np.random.default_rng([seed, 1]).normal(size=samples)
    start = "unknown" if lead else "rest"
    return Trace(f"{seed}.csv", t, drive(t), noisy, ONE, ONE, NoiseFloor(SIGMA), start)


def campaign(*records: Trace) -> Campaign:
    return Campaign("a", records, Oscillator())


def test_a_relaxation_that_began_before_its_record_is_predicted_to_the_noise():
    model = Model(Oscillator()) + LIBRARY["viscoelastic-support"]()
    values = np.array([FREQUENCY, QUALITY, GAIN, SOFT, TIME, 1.0, 0.5])
    cut = record(3, 0.07)
    found = fit_at(model, campaign(cut), values)
    assert found.fitted.error_over_noise < 1.05
    at_rest = fit_at(model, campaign(replace(cut, start="rest")), values)
    assert at_rest.fitted.error_over_noise > 3


def test_its_parameters_come_out_within_their_error_bars():
    model = Model(Oscillator(), (), held=frozenset({"viscoelastic-support.spread"}))
    model = model + LIBRARY["viscoelastic-support"](spread=1.0)
    model = replace(model, start=(("viscoelastic-support.spread", 1.0),))
    found = fit(model, campaign(record(3, 0.07), record(4, 0.11), record(5, 0.0)))
    assert found.fitted.error_over_noise < 1.05
    for name, true in {"frequency": FREQUENCY, "quality": QUALITY, "stiffness": SOFT, "time": TIME}.items():
        estimate = next(e for e in found.estimates if e.name.endswith("." + name))
        assert estimate.standard_error is not None
        assert abs(estimate.value - true) < 4 * estimate.standard_error, estimate


def test_scores_allow_for_what_came_before():
    linear = fit(Model(Oscillator()), campaign(record(3, 0.07), record(4, 0.11)))
    best = score(prepare(linear), {name: LIBRARY[name] for name in ("viscoelastic-support", "creep", "drive-lag")})[0]
    assert best.name == "viscoelastic-support"
    assert best.predicted_gain > 0.999


def test_a_fit_at_the_values_of_a_search_begins_as_that_ended_and_so_does_its_run(monkeypatch, tmp_path):
    """A play never forgets how a record began; on a PZT stage others left 130 noise floors instead of 98."""
    monkeypatch.setattr(rebuild, "fit_starts", lambda static, data, there: (there, evaluate(static, data, there)))
    model = Model(Oscillator()) + LIBRARY["backlash"](width=0.5)
    cut, begun = campaign(record(3, 0.07)), np.array([[0.3, 20.0, -0.2]])
    values = np.array([FREQUENCY, QUALITY, GAIN, *LIBRARY["backlash"](width=0.5).values.values()])
    there = fit_at(model, cut, values, begun=begun)
    np.testing.assert_allclose(there.solved.found.starts, begun, rtol=1e-9)
    assert not np.allclose(fit_at(model, cut, values).solved.found.starts, begun, rtol=0.1)
    document = json.loads(json.dumps({**run_dict(there), "state": state(there)}, allow_nan=False))
    np.testing.assert_allclose(rebuild_in(cut, document, tmp_path).solved.found.starts, begun, rtol=1e-9)


MEMORIES = {
    "viscoelastic-support": {"stiffness": 6e3, "time": 0.02, "spread": 2.0},
    "creep": {"late": 0.1, "time": 0.05, "spread": 2.0},
    "bouc-wen": {"friction": 1e3, "travel": 0.5},
    "bouc-wen-drive": {"loop": 0.2, "travel": 0.5},
    "second-mode": {"travel": 0.01, "period": 0.01},
}


@pytest.mark.parametrize("name", MEMORIES)
def test_derivatives_by_a_history_agree_with_differences(name):
    trace = record(6, 0.05, 300)
    voltage, rate = half_step_drive(trace, 1)
    tape = lay([Lane(trace.step, voltage, rate, OMEGA)], [1])
    effect = LIBRARY[name](Oscillator(), **MEMORIES[name])
    equation = Equation(Model(Oscillator(), (effect,)))
    values = np.array([FREQUENCY, QUALITY, GAIN, *effect.values.values()])
    size = 2 + len(equation.history_units)
    start = 0.1 * np.random.default_rng(0).normal(size=(1, size))
    kicks = np.eye(size)[:, None]
    slopes = respond(equation, tape, values, start, np.zeros((size, len(values))), kicks).slopes
    for kick, slope in zip(kicks, slopes, strict=True):
        up, down = (respond(equation, tape, values, start + sign * 1e-5 * kick).readings for sign in (1, -1))
        change = (up - down) / 2e-5
        assert np.max(np.abs(change)) > 0
        assert np.allclose(slope, change, rtol=0, atol=1e-4 * np.max(np.abs(change)))


def test_a_history_of_nothing_changes_nothing():
    trace = record(6, 0.0, 300)
    voltage, rate = half_step_drive(trace, 1)
    tape = lay([Lane(trace.step, voltage, rate, OMEGA)], [1])
    effects = tuple(LIBRARY[name](Oscillator(), **MEMORIES[name]) for name in ("creep", "viscoelastic-support"))
    equation = Equation(Model(Oscillator(), effects))
    values = np.array([FREQUENCY, QUALITY, GAIN, *(x for effect in effects for x in effect.values.values())])
    wide = np.zeros((1, 2 + len(equation.history_units)))
    plain, long = (respond(equation, tape, values, starts).readings for starts in (np.zeros((1, 2)), wide))
    assert np.allclose(plain, long, rtol=0, atol=1e-12 * np.max(np.abs(plain)))


def test_a_point_without_a_bound_has_no_history():
    """A grid point whose memory grows without end scores nothing, and spoils no other."""
    rows, changed = np.ones((2, 40)), np.full((1, 2, 40), 2.0)
    rows[1, 3] = np.inf
    changed[0, 1, 5] = np.nan
    record = SimpleNamespace(start="unknown")
    regression = SimpleNamespace(
        places=(slice(0, 40),), residual=np.ones(40), absorbed=np.zeros((40, 0)),
        fit=SimpleNamespace(campaign=SimpleNamespace(fitted=(record,))),
    )  # fmt: skip
    found = histories(regression, changed, rows)  # type: ignore[arg-type]
    assert np.all(found.rows[0, 0] == 1.0) and np.all(found.rows[0, 1] == 0.0)
    assert found.fitted(regression, rows[1:], slice(1, 2))[2] == 0.0  # type: ignore[arg-type]
    past, _, _ = found.fitted(regression, rows[:1], slice(0, 1))  # type: ignore[arg-type]
    assert np.all(np.isfinite(found.added(rows[:1], past, slice(0, 1))))
    silent = histories(regression, np.full((1, 2, 40), 2.0), np.zeros((2, 40)))  # type: ignore[arg-type]
    assert np.all(silent.rows == 0.0), "what does nothing in any record is not seen by a history"
