"""A sensor whose zero moves between records, beside two effects, simulated with SciPy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ident
from ident.campaign.apart import as_it_came, floating, read_apart
from ident.campaign.campaign import Campaign
from ident.diagnosis.linearised import shorten
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.linearised.shorten import working
from ident.diagnosis.ranking.look import Look, first_look
from ident.diagnosis.records.differing import without_common_zero
from ident.diagnosis.search.change import add
from ident.diagnosis.search.last_zeros import with_last_zeros
from ident.diagnosis.search.own_zeros import has_own_zeros, with_own_zeros
from ident.diagnosis.search.together import two_names_do
from ident.effects.registry import built_in
from ident.fit.fit import fit

STEP, W, NOISE = 1 / 400, 2 * np.pi * 11.0, 0.02
TONES = ((10.8,), (7.0, 9.5, 12.5), (11.4,), (5.0, 10.2, 13.0), (8.0, 11.0, 12.0))
ZEROS = np.array([0.06, -0.05, 0.02, 0.09, -0.12])  # the last record is held out
LOUD = (1.0, 0.7, 0.4, 0.8, 0.8)
LAWS = ("cubic-stiffness", "quadratic-damping")


def _campaign(zeros: np.ndarray = ZEROS, samples: int = 1500, square: float = 0.0) -> Campaign:
    """With a cubic spring and a quadratic drag, or with a square spring instead."""
    rng, records = np.random.default_rng(21), []
    for k, (tones, zero, loud) in enumerate(zip(TONES, zeros, LOUD, strict=True)):
        phases = rng.uniform(0, 2 * np.pi, len(tones))
        time = STEP * np.arange(-800, samples)  # records begin in motion

        def push(t, tones=tones, phases=phases, loud=loud):
            return loud * sum(np.sin(2 * np.pi * f * t + a) for f, a in zip(tones, phases, strict=True))

        def law(t, y, push=push):
            cubic, drag = (0.0, 0.0) if square else (0.02 * y[0] ** 3, 0.02 * y[1] * abs(y[1]))
            return [y[1], 400.0 * push(t) - W**2 * (y[0] + cubic + square * y[0] ** 2 / 10) - W / 30 * y[1] - drag]

        moved = solve_ivp(law, (time[0], time[-1]), [0, 0], t_eval=time, rtol=1e-8, atol=1e-9)
        read = moved.y[0][800:] + zero + NOISE * rng.normal(size=samples)
        table = {"time": time[800:], "drive": push(time[800:]), "response": read}
        records.append({"data": table, "start": "unknown", "holdout": k == len(TONES) - 1})
    return ident.read_campaign({"device": {"kind": "oscillator"}, "record": records})


def _with_both(campaign: Campaign) -> ident.Fit:
    return add(add(ident.fit(campaign, effects=()), LAWS[0]), LAWS[1])


def _look(fitted: ident.Fit) -> Look:
    regression = prepare(working(fitted))
    return Look(regression, regression, built_in(), lambda _: None)


def test_zeros_of_the_records_own_take_no_name_and_refute_none():
    found = ident.discover(_campaign())
    assert {step.added for step in found.discovery.steps} == set(LAWS)
    assert set(found.final.model.names) == set(LAWS)  # and no common zero
    assert found.final.fitted.error_over_noise == pytest.approx(1.0, abs=0.04)
    assert found.final.holdout is not None and found.final.holdout.error_over_noise == pytest.approx(1.0, abs=0.06)
    told = [trace.own[1][0] for trace in found.final.campaign.traces if trace.own]
    np.testing.assert_allclose(told, ZEROS, atol=5 * NOISE / np.sqrt(1500))
    (note,) = [note for note in found.final.campaign.notes if "a zero of its own" in note]
    assert f"{1e3 * told[0]:+.2g} mV ± " in note.replace("µV", "mV")


def test_they_are_asked_for_beside_what_is_named_and_only_where_they_differ():
    one = _with_both(_campaign())
    campaign = with_own_zeros(one, _look(one))
    assert campaign is not None and has_own_zeros(campaign)
    same = _with_both(_campaign(zeros=np.full(5, 0.05)))
    assert with_own_zeros(same, _look(same)) is None
    read_so = ident.fit(campaign, effects=LAWS)
    assert with_own_zeros(read_so, _look(read_so)) is None  # once is enough


def test_where_they_do_not_differ_effects_come_first():
    """What moves the mean with the amplitude is no zero of the sensor."""
    fitted = ident.fit(_campaign(zeros=np.zeros(5)), effects=())
    assert with_own_zeros(fitted, _look(fitted)) is None


def test_they_are_found_again_from_the_records_as_they_came():
    fitted = _with_both(_campaign())
    bent = tuple(read_apart(trace, "level", (0.03,)) for trace in fitted.campaign.traces)
    for came, read in zip(fitted.campaign.traces, bent, strict=True):
        np.testing.assert_allclose(as_it_came(read).response, came.response, atol=1e-12)
    bare = without_common_zero(fitted)
    again = fit(bare.model, floating(replace(fitted.campaign, records=bent)), initial=bare.values)
    told = [trace.own[1][0] for trace in again.campaign.traces if trace.own]
    np.testing.assert_allclose(told, ZEROS, atol=5 * NOISE / np.sqrt(1500))
    (note,) = [
        note
        for note in with_last_zeros(again, built_in(), lambda _: None).campaign.notes
        if "a zero of its own" in note
    ]
    assert f"{1e3 * told[0]:+.2g} mV ± " in note.replace("µV", "mV")
    assert with_last_zeros(fitted, built_in(), lambda _: None) is fitted


@pytest.mark.parametrize("zero", [0.0, 0.08])
def test_those_that_the_last_model_does_not_need_are_taken_back(zero: float):
    """An earlier model had needed them; one zero for all stays, if there is one."""
    fitted = _with_both(_campaign(np.full(5, zero)))
    bare = without_common_zero(fitted)
    read = tuple(read_apart(trace, "level", (0.03,)) for trace in fitted.campaign.traces)
    note = "The records agree only if each has a zero of its own: +30 mV in a.csv"
    campaign = floating(replace(fitted.campaign, records=read, notes=("kept", note)))
    last = with_last_zeros(fit(bare.model, campaign, initial=bare.values), built_in(), lambda _: None)
    assert last.campaign.notes == ("kept",) and not has_own_zeros(last.campaign)
    common = [last.value(p.name) for p in last.model.parameters if p.name == "sensor-offset.offset"]
    assert common == ([pytest.approx(zero, abs=5e-3)] if zero else [])


def test_small_ones_that_the_records_choose_stay():
    """Four numbers that lower χ² by eighty."""
    fitted = _with_both(_campaign(0.003 * np.array([1.0, -1.0, 1.0, -1.0, 1.0])))
    bare = without_common_zero(fitted)
    read = tuple(read_apart(trace, "level", (0.0,)) for trace in fitted.campaign.traces)
    campaign = floating(replace(fitted.campaign, records=read))
    assert has_own_zeros(
        with_last_zeros(fit(bare.model, campaign, initial=bare.values), built_in(), lambda _: None).campaign
    )


def test_a_law_that_moves_the_mean_is_told_beside_them():
    """Zeros are no reason to call a square something else, nor a square one to see zeros."""
    for zeros in (ZEROS, np.zeros(5)):
        found = ident.discover(_campaign(zeros, square=0.25))
        assert [step.added for step in found.discovery.steps] == ["quadratic-stiffness"]
        assert has_own_zeros(found.final.campaign) == bool(np.any(zeros))
        assert found.final.holdout is not None and found.final.holdout.error_over_noise == pytest.approx(1.0, abs=0.06)
        if np.any(zeros):
            told = [trace.own[1][0] for trace in found.final.campaign.traces if trace.own]
            np.testing.assert_allclose(told, zeros, atol=6 * NOISE / np.sqrt(1500))


def test_long_records_tell_them_by_a_stretch_of_each(monkeypatch):
    monkeypatch.setattr(shorten, "_MOST", 10_000)
    monkeypatch.setattr(shorten, "_KEPT", 2400)
    fitted = _with_both(_campaign())
    campaign = with_own_zeros(fitted, _look(fitted))
    assert campaign is not None and [len(trace.time) for trace in campaign.traces] == [1500] * 5
    told = [trace.own[1][0] for trace in campaign.traces if trace.own]
    np.testing.assert_allclose(told, ZEROS, atol=5 * NOISE / np.sqrt(500))


def test_two_names_that_reach_the_noise_are_known_before_the_walk():
    """So that no faulty record is sought beside one of them."""
    fitted = ident.fit(_campaign(zeros=np.zeros(5)), effects=())
    look = first_look(fitted, built_in(), lambda _: None)
    assert two_names_do(look, prepare(fitted))
