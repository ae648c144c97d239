"""A walk begins again where its first model had been wrong: simulated with SciPy."""

from __future__ import annotations

import numpy as np
from scipy.signal import cont2discrete, lfilter

import ident
from ident.diagnosis.search.once_more import lower_start
from ident.fit import fit

STEP, LATE = 0.08, 3  # s, and samples by which the response comes too late


def _heater(seed: int) -> dict[str, object]:
    """Two time constants and a dead time, under a voltage that jumps and is held."""
    rng = np.random.default_rng(seed)
    drive = 5 + np.repeat(rng.choice([-1.0, 1.0], 170), 6)[:1000]
    one, two = 0.5, 0.15
    (b,), a, *_ = cont2discrete(([0.9], [one * two, one + two, 1.0]), STEP)
    late = np.concatenate([np.full(LATE, drive[0]), drive[:-LATE]])
    response = lfilter(b, a, late - drive[0]) + 0.9 * drive[0] + rng.normal(0, 0.02, len(drive))
    return {"data": {"time": STEP * np.arange(1000), "drive": drive, "response": response}, "holdout": seed == 2}


def test_a_dead_time_is_no_effect():
    found = ident.discover({"device": {"kind": "oscillator"}, "record": [_heater(1), _heater(2)]})
    assert found.final.model.names in ((), ("sensor-offset",)) and found.verdict == "adequate"
    assert found.final.model.form == "overdamped"
    assert abs(found.final["quality"].value / 0.4213 - 1) < 0.03
    assert all(abs((trace.edge or 0.0) - LATE) < 0.15 for trace in found.final.campaign.traces)


def test_a_name_does_not_stay_for_the_way_that_it_showed():
    campaign = ident.read_campaign({"device": {"kind": "oscillator"}, "record": [_heater(1)]})
    there = ident.discover(campaign).final
    lost = fit(there.model, there.campaign, initial=there.values * [3.0, 0.2, 1.0], most=1)
    assert lost.fitted.error_over_noise > 2 * there.fitted.error_over_noise
    lower = lower_start(lost, there, lambda _: None)
    assert lower is not None and lower.fitted.chi2 < 1.01 * there.fitted.chi2
    assert lower_start(there, there, lambda _: None) is None
