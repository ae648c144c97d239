"""When is another law better, and when is it only more flexible? When may a sign not be?"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.evidence.enough import laws_differ_by
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.ranking.score import score
from ident.diagnosis.search.change import add
from ident.diagnosis.search.lacking import lacking
from ident.effects.library.quadratic_damping import QuadraticDamping
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.reading import read
from ident.model import Model

STEP, NOISE = 1 / 6000.0, 0.003


def regression(excess: float, n: int = 1000) -> Any:
    return SimpleNamespace(chi2=n + excess, n=n, excess=excess)


def test_a_flexible_law_owes_its_lead_to_its_shapes_only_as_far_as_it_lacks_something_itself() -> None:
    assert laws_differ_by(regression(1e6), left=1000.0) == 0.0  # it describes the records: it is the better law
    assert laws_differ_by(regression(1e6), left=1000.0 + 100.0) == pytest.approx(100.0)
    assert laws_differ_by(regression(1e6), left=1000.0 + 1e4) == pytest.approx(3000.0)  # 0.3 % of the excess
    assert laws_differ_by(regression(1e6), left=1000.0 + 1e6) == pytest.approx(20000.0)  # much is still to be explained


@pytest.mark.parametrize(("strength", "seen"), [(1e-4, True), (-1e-4, False)])
def test_a_damping_that_drives_scores_nothing(strength: float, seen: bool) -> None:
    time, channel = STEP * np.arange(1200), Channel("V", 1.0)
    model, records = Model(Oscillator()) + QuadraticDamping(), []
    for k, (volts, hertz) in enumerate([(1.0, 97.0), (3.0, 101.0)]):
        drive = volts * np.sin(2 * np.pi * hertz * time)
        blank = Trace(f"{k}.csv", time, drive, np.ones(1200), channel, channel, NoiseFloor(NOISE), "rest")
        clean = read(model, np.array([100.0, 20.0, 4e5, strength, 0.0]), [blank])[0]
        noise = NOISE * np.random.default_rng(k).standard_normal(1200)
        records.append(Trace(f"{k}.csv", time, drive, clean + noise, channel, channel, NoiseFloor(NOISE), "rest"))
    linear = fit(Model(Oscillator()), Campaign("two sines", tuple(records), Oscillator()))
    (found,) = score(prepare(linear), {"quadratic-damping": QuadraticDamping})
    assert linear.fitted.error_over_noise > 2
    assert (found.drop > 0) is seen
    assert (found.p_value < 1e-6) is seen


@pytest.mark.parametrize(("detail", "doubted"), [("own", True), ("plain", False)])
def test_the_curve_of_a_named_law_is_questioned(detail: str, doubted: bool) -> None:
    """A spring that saturates a little, called cubic, leaves 0.006 % of the misfit; a cubic one leaves nothing."""
    case = draw(5010, ("cubic-stiffness",), size=0.02, noise=0.001, detail=detail)  # type: ignore[arg-type]
    campaign = campaign_of(case)
    linear = fit(Model(campaign.device), campaign)
    named = add(linear, built_in()["cubic-stiffness"])
    share = lacking(prepare(named), prepare(linear))
    assert named.fitted.error_over_noise < 1.05
    assert (2e-5 < share < 1e-3) if doubted else share == 0.0
