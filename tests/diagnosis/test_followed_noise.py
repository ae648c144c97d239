"""Slow noise above its floor moves the measured motion, and is then read as its own cause: that is no law."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.signal import lfilter

from ident.campaign import Campaign, Trace
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor
from ident.diagnosis.diagnose import diagnose
from ident.diagnosis.search import written
from ident.fit import fit
from ident.model import build_model
from ident.report.diagnosis_view import verdict_words

_OMEGA, _FLOOR = 2 * np.pi * 10.0, 0.005  # of the response, and less than a third of its slow noise


def _record(seed: int) -> Trace:
    """A linear oscillator under a multisine, read with noise of which neighbours share nineteen twentieths."""
    rng = np.random.default_rng(seed)
    rates, phases = 2 * np.pi * np.linspace(4.0, 18.0, 29), rng.uniform(0, 2 * np.pi, 29)
    push = lambda t: float(np.sin(rates * t + phases).sum())
    law = lambda t, y: (y[1], _OMEGA**2 * (push(t) - y[0]) - 0.06 * _OMEGA * y[1])
    time = np.arange(1000) / 180.0
    z = solve_ivp(law, (0, time[-1]), (3.0, 0.0), t_eval=time, rtol=1e-9, atol=1e-9).y[0]
    slow = lfilter([1.0], [1.0, -0.95], rng.standard_normal(len(time))) * np.sqrt(1 - 0.95**2)
    reading = z + 0.02 * float(np.std(z)) * slow
    unit, floor = Channel("m", 1.0), NoiseFloor(_FLOOR * float(np.std(z)), method="too low")
    return Trace(f"{seed}.csv", time, np.array([push(t) for t in time]), reading, Channel("N", 1.0), unit, floor)


def test_what_a_simulation_does_not_keep_is_not_named(tmp_path: Path):
    campaign = Campaign("test", (_record(1), _record(2)), Oscillator("m", "N"), linear="oscillator")
    start = fit(build_model(campaign), campaign)
    assert start.fitted.error_over_noise > 3.0
    file = tmp_path / "unknown.py"
    found = diagnose(start, {}, effect_file=file, keeps_walk=True)
    assert found.unknown is not None and found.unknown.share > 0.2
    assert not found.discovery.steps and found.verdict == "ambiguous" and not file.exists()
    assert "is no law" in " ".join(found.unknown.sentences)
    assert verdict_words(found).startswith("Nothing is named")


def test_an_effect_that_takes_a_tenth_helps_only_where_no_floor_is_that_wrong():
    first: Any = SimpleNamespace(chi2=500.0, n=100.0, excess=400.0, above_noise=400.0)
    for error, helps in ((2.3, False), (20.0, True)):
        fitted = SimpleNamespace(fitted=SimpleNamespace(error_over_noise=error))
        found: Any = SimpleNamespace(start=fitted, confirmed={"pzt-hysteresis": 0.105})
        assert written._helped(found, first) is helps
