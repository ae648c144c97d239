"""A stiff stop on a shaken stage: the equation of motion without it makes nonsense of gain and damping. Where refits
from there keep nothing, the effect is looked for from the values of the fit."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.linearised.anchor import prepare_at_best
from ident.diagnosis.linearised.regression import Regression
from ident.diagnosis.ranking import look
from ident.diagnosis.ranking.confirm import Confirmed, confirm
from ident.diagnosis.ranking.weigh import Candidate
from ident.effects.effect import AbstractEffect
from ident.effects.registry import built_in
from ident.fit import Fit, fit
from ident.model import Model

OMEGA, QUALITY, GAP, CONTACT = 2 * np.pi * 141.0, 26.0, 62e-6, 30.0
STEP, SIGMA = 1 / 6000, 1e-7
LIBRARY = {name: built_in()[name] for name in ("cubic-stiffness", "end-stop", "quadratic-damping", "sensor-lag")}


def record(name: str, drive: np.ndarray, seed: int) -> Trace:
    """The distance of a stage from its base, which is shaken; stops without losses on both sides (SciPy)."""
    time, between = STEP * np.arange(len(drive)), CubicSpline(STEP * np.arange(len(drive)), drive)

    def rate(t: float, y: np.ndarray) -> list[float]:
        beyond = max(y[0] - GAP, 0.0) - max(-y[0] - GAP, 0.0)
        return [y[1], -between(t) - OMEGA / QUALITY * y[1] - OMEGA**2 * (y[0] + CONTACT * beyond)]

    span = (0.0, float(time[-1]))
    found = solve_ivp(rate, span, [0.0, 0.0], "DOP853", time, rtol=1e-9, atol=1e-13, max_step=STEP)
    noise = SIGMA * np.random.default_rng(seed).standard_normal(len(time))
    floor, channel = NoiseFloor(SIGMA, method="given"), Channel("V", 1.0)
    return Trace(name, time, drive, found.y[0] + noise, channel, channel, floor, "rest")


@pytest.fixture(scope="module")
def shaken() -> Fit:
    time = STEP * np.arange(2400)
    chirp = lambda first, last: np.sin(2 * np.pi * (first * time + (last - first) * time**2 / (2 * time[-1])))
    drives = {
        "weak": 1.2 * np.sin(2 * np.pi * 140 * time),
        "weak chirp": 1.5 * chirp(90.0, 200.0),
        "strong": 4.5 * np.sin(2 * np.pi * 146 * time),
        "strong chirp": 5.0 * chirp(90.0, 210.0),
    }
    # What is asked here is where is looked from. The search for the stop itself ends elsewhere with the noise of every
    # second seed, with a cubic spline between the samples as with the drive itself: these are not among them.
    records = tuple(record(name, drive, seed) for seed, (name, drive) in enumerate(drives.items(), 40))
    return fit(Model(Oscillator()), Campaign("shaken", records, Oscillator()))


def test_where_refits_keep_nothing_the_fit_s_own_values_are_looked_from(
    shaken: Fit, monkeypatch: pytest.MonkeyPatch
) -> None:
    there = prepare_at_best(shaken)
    assert there.instead_of is not None
    assert there.fit.value("oscillator.quality") > 10 * QUALITY  # nonsense

    def keeps_nothing(
        regression: Regression, effect: type[AbstractEffect], candidate: Candidate, *, refining: bool
    ) -> Confirmed:
        found = confirm(regression, effect, candidate, refining=refining)
        return found if regression.instead_of is None else found._replace(chi2=regression.best_chi2)

    monkeypatch.setattr(look, "confirm", keeps_nothing)
    seen = look.first_look(shaken, LIBRARY, lambda _: None)
    assert seen.regression.instead_of is None and not seen.broken
    best = min(seen.tried, key=lambda found: found.chi2)
    assert best.candidate.name == "end-stop" and best.chi2 < 1.2 * seen.regression.n
    gap = [p.name for p in best.model.parameters].index("end-stop.gap")
    assert best.values[gap] == pytest.approx(GAP, rel=0.01)
