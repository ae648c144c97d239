"""An amplitude that is positive is not scored at a point of the grid that asks for a negative one."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.ranking.confirm import accept, confirm
from ident.diagnosis.ranking.score import score
from ident.effects.registry import built_in
from ident.fit import Fit, fit
from ident.model import Model


@pytest.fixture(scope="module")
def linear() -> Fit:
    """Of a stage under residual stress, simulated by laws of the study's own, with noise of 1 %."""
    campaign = campaign_of(draw(8930, ("residual-stress",), size=0.02, noise=0.01))
    return fit(Model(campaign.device), campaign)


def test_residual_stress_is_refitted_to_the_noise(linear: Fit) -> None:
    """A restraint of less than nothing had won the grid, and its refit ran away to a stress of 100 GPa."""
    regression, law = prepare(linear), built_in()["residual-stress"]
    (found,) = score(regression, {law.name: law})
    sizes = SimpleNamespace(**found.values)
    assert sizes.restraint >= 0 and all(near["restraint"] >= 0 for near in found.near)
    refit = confirm(regression, law, found)
    assert refit.possible
    after = accept(refit, linear)
    assert after.fitted.error_over_noise < 1.05
    assert after.holdout is not None and after.holdout.error_over_noise < 1.1
    assert np.all(np.isfinite(after.values))
