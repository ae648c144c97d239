"""Shapley values by their axioms, folding against a closed form, and the offset of a device whose cause is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ident.campaign import read_campaign
from ident.errors import UserError
from ident.fit.fit import fit
from ident.model import build_model
from ident.posterior.attribution import attribute
from ident.posterior.density import make_density
from ident.posterior.offset import MEASURES, fold, offsets
from ident.posterior.shapley import shapley, subsets
from tests.end_to_end.user import DATA
from tests.report.conftest import sine_trace


def test_shares_add_up_and_a_mechanism_that_changes_nothing_gets_nothing():
    random = np.random.default_rng(0)
    values = {s: random.standard_normal(5) for s in subsets(3)}
    assert shapley(values, 3).sum(axis=0) == pytest.approx(values[(0, 1, 2)] - values[()])
    idle = {s: values[tuple(i for i in s if i != 1)] for s in subsets(3)}
    assert shapley(idle, 3)[1] == pytest.approx(np.zeros(5))
    product = {s: np.array([float({0, 1} <= set(s))]) for s in subsets(2)}
    assert shapley(product, 2)[:, 0] == pytest.approx([0.5, 0.5])


def test_many_readings_are_folded_as_one_is():
    trace = sine_trace("a.csv", 2.0, 300.0, offset=3e-7)
    turn = 2 * np.pi / trace.period * np.arange(len(trace.time))
    reading = 3e-7 + 2e-6 * np.sin(turn - 0.5) + 1e-7 * np.cos(2 * turn)
    folded = fold(trace, np.stack([reading, 2 * reading]))
    told = offsets(trace, reading)
    assert folded.measures[0] == pytest.approx([o.model.value for o in told])
    assert folded.measures[1][0] == pytest.approx(6e-7)
    assert folded.second[0] == pytest.approx([0.0, 1e-7], abs=1e-12)
    assert len(MEASURES) == folded.measures.shape[1]


def shortened(name: str, effects: tuple[str, ...], samples: int = 1200):
    campaign = read_campaign(DATA / name)
    cut = lambda r: replace(r, time=r.time[:samples], drive=r.drive[:samples], response=r.response[:samples])
    records = tuple(cut(r) for r in campaign.traces if not r.holdout)
    data = replace(campaign, records=records)
    return fit(build_model(data, effects), data)


def test_residual_stress_explains_the_offset_of_the_paper_and_hysteresis_hardly_any():
    found = attribute(shortened("platform_317hz", ("residual-stress", "pzt-hysteresis")))
    assert found.verdict == "one mechanism" and found.leading == ("residual-stress",)
    first = next(r for r in found.records if r.record.name == "sine_8V_317Hz.csv")
    mean = first.measures[0]
    assert mean.counts
    shares = {s.mechanism: s for s in mean.shares}
    assert shares["residual-stress"].share == pytest.approx(1.0, abs=0.1)
    assert abs(shares["pzt-hysteresis"].alone) < 0.02
    assert sum(s.share for s in mean.shares) == pytest.approx(1.0, abs=0.01)


def test_an_effect_says_which_of_its_amplitudes_it_was():
    """The drive's own axial force, not the initial deflection: the records were made so."""
    found = attribute(shortened("platform_317hz", ("residual-stress", "pzt-hysteresis")))
    within = {s.mechanism: s.share for s in found.within}
    assert set(within) == {"residual-stress.restraint", "residual-stress.voltage_force"}
    assert sum(within.values()) == pytest.approx(1.0, abs=0.01)
    assert within["residual-stress.voltage_force"] > 0.8
    assert "Within residual-stress: restraint" in found.words


def test_a_doubt_about_the_model_leaves_the_verdict_open():
    found = attribute(
        shortened("platform_317hz", ("residual-stress", "pzt-hysteresis")), doubts=lambda _: ("a tooth is missing",)
    )
    assert found.verdict == "undecided" and "a tooth is missing" in found.words


def test_a_model_that_lacks_the_cause_blames_nobody():
    """Hysteresis alone cannot describe a stressed platform, and is not made to answer for its offset."""
    found = attribute(shortened("platform_317hz", ("pzt-hysteresis",)))
    assert found.verdict == "undecided"
    assert any("ident diagnose" in reason for reason in found.reasons)


def test_a_linear_model_has_nothing_to_attribute_to():
    with pytest.raises(UserError, match="no effect"):
        attribute(shortened("platform_clean", ()))


def test_symmetric_physics_has_no_offset_while_it_settles():
    """Hysteresis of a device from rest makes none, transient or not; what makes one is even when it is turned round."""
    found = shortened("platform_317hz", ("residual-stress", "pzt-hysteresis"), samples=600)
    density = make_density(found)
    values = np.asarray(found.values)[None].copy()
    switch = [
        i for i, p in enumerate(found.model.parameters) if p.kind == "amplitude" and p.effect == "residual-stress"
    ]
    for with_stress in (True, False):
        if not with_stress:
            values[:, switch] = 0.0
        ahead, back = (d.readings(values)[0] for d in (density, density.mirrored()))
        even = np.max(np.abs(ahead + back)) / np.max(np.abs(ahead))
        assert even > 0.02 if with_stress else even < 1e-9


def test_records_of_one_file_are_not_taken_for_one_another():
    """Two records may be columns of one table, and are then called alike."""
    one = shortened("platform_317hz", ("residual-stress",), samples=800)
    called = {id(r): replace(r, name="table.csv") for r in one.campaign.records}
    alike = replace(one, campaign=replace(one.campaign, records=tuple(called[id(r)] for r in one.campaign.records)))
    told = [attribute(fit, fit.values[None]).records for fit in (one, alike)]
    models = [[m.offset.model for r in records for m in r.measures] for records in told]
    assert len(told[0]) > 1 and models[0] == models[1]
