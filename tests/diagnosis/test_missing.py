"""An effect that the size of what is left does not betray is seen by the score test, and noise is not taken for one."""

from __future__ import annotations

import pytest

from experiments.posterior.calibration import case
from ident.diagnosis.missing import missing
from ident.effects.registry import registry
from ident.posterior.density import make_density
from ident.posterior.misfit import misfit


@pytest.mark.parametrize("hidden", [True, False])
def test_a_damping_hidden_under_much_noise_is_seen(hidden):
    _, found = case(3, "white", "rest", hidden, sigma=0.05)
    assert not misfit(make_density(found)).reasons
    reasons = missing(found, registry(()))
    assert bool(reasons) == hidden
    assert all("damping" in reason and "ident diagnose" in reason for reason in reasons)
