"""Levels of sweeps whose drives are not what they are called."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.diagnosis.diagnose import diagnose
from ident.diagnosis.records.between import differing
from ident.effects.registry import built_in
from ident.fit import Fit, fit
from ident.model import Model
from ident.report.run_state import state
from tests.fit.test_curves import CUBIC, sweep

CALLED = np.array([0.15, 0.2, 0.3, 0.4])
ACTING = np.array(
    [1.05, 1.02, 0.97, 0.95]
)  # a force that droops the more the larger it is; of the last but one nothing
HELD = 2


def _campaign(acting: np.ndarray, phase: bool) -> Campaign:
    records = []
    for k, (called, times) in enumerate(zip(CALLED, acting, strict=True)):
        one = sweep(called * times, CUBIC, phase, k)
        records.append(replace(one, name=f"{called} V", level=np.full(len(one.level), called), holdout=k == HELD))
    return Campaign("", tuple(records), Oscillator(output="m"))


def _fit(campaign: Campaign) -> Fit:
    model = Model(campaign.device) + built_in()["cubic-stiffness"](campaign.device)
    return fit(model, campaign)


@pytest.mark.parametrize("phase", [True, False])
def test_the_drives_of_the_levels_are_found_with_their_errors(phase: bool) -> None:
    fitted = _fit(_campaign(ACTING, phase))
    assert fitted.fitted.error_over_noise > 2.0
    found = differing(fitted)
    assert found is not None and found.kind == "drive"
    logarithms = np.log(ACTING)
    wanted = np.expm1(logarithms - np.mean(np.delete(logarithms, HELD)))
    assert np.all(np.abs(found.sizes[:, 0] - wanted) < 4 * found.errors[:, 0] + 0.001)
    assert found.fit.fitted.error_over_noise == pytest.approx(1.0, abs=0.07)
    assert found.fit.holdout is not None and found.fit.holdout.error_over_noise == pytest.approx(1.0, abs=0.15)
    assert "at 0.15 V" in found.words


def test_levels_of_one_drive_do_not_differ() -> None:
    assert differing(_fit(_campaign(np.ones(4), True))) is None


def test_a_walk_goes_on_beside_what_differs() -> None:
    campaign = _campaign(ACTING, True)
    found = diagnose(fit(Model(campaign.device), campaign))
    assert [step.added for step in found.discovery.steps] == ["cubic-stiffness"]
    assert found.verdict == "ambiguous"
    assert found.final.fitted.error_over_noise == pytest.approx(1.0, abs=0.07)
    assert any("a drive of its own" in note for note in found.final.campaign.notes)
    assert state(found.final)["stronger"][0][0] == pytest.approx(0.05, abs=0.02)
