"""An effect that the size of what is left does not betray is seen by the score test, and noise is not taken for one."""

from __future__ import annotations

from dataclasses import replace

import pytest

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from experiments.posterior.calibration import case
from ident.diagnosis.ranking.missing import missing
from ident.effects.registry import registry
from ident.fit.fit import fit
from ident.model import build_model
from ident.posterior.density import make_density
from ident.posterior.misfit import misfit


@pytest.mark.parametrize("hidden", [True, False])
def test_a_damping_hidden_under_much_noise_is_seen(hidden):
    _, found = case(3, "white", "rest", hidden, sigma=0.05)
    assert not misfit(make_density(found)).reasons
    reasons = missing(found, registry(()))
    assert bool(reasons) == hidden
    assert all("damping" in reason and "ident diagnose" in reason for reason in reasons)


def test_what_the_parameters_absorb_of_the_fitted_records_shows_in_the_held_out_ones():
    """An end stop that a cubic spring follows, to a thirtieth of the noise, as long as the level is not another."""
    campaign = campaign_of(draw(3002, ("end-stop", "cubic-stiffness"), size=0.02, noise=0.1))
    found = fit(build_model(campaign, ("cubic-stiffness",)), campaign)
    alone = replace(campaign, records=campaign.fitted)
    assert not missing(fit(found.model, alone, initial=found.values), registry(()))
    assert any("held-out" in reason for reason in missing(found, registry(())))
