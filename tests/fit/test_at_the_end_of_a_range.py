"""A parameter whose best value lies beyond its range: the search lands on the end and goes on with the others."""

from __future__ import annotations

from dataclasses import replace

import pytest

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.diagnosis.search.change import add
from ident.fit import fit
from ident.model import Model


def test_a_search_lands_on_the_end_of_a_range_and_does_not_creep_towards_it() -> None:
    """A soft contact in the place of a cubic spring: towards a bound of the bounded coordinate slope and curvature
    vanish together, and every start took 28 to 39 steps."""
    campaign = campaign_of(draw(42, ("cubic-stiffness",), size=0.03, noise=0.005, records=3, length=800))
    # With equal gaps: unequal ones make a valley of their own.
    plain = replace(Model(campaign.device), held=frozenset({"end-stop.asymmetry"}))
    found = add(fit(plain, campaign), "end-stop")
    at_end = found["exponent"]
    assert at_end.value == pytest.approx(1.8, rel=1e-9) and at_end.error is None and "at-bound" in at_end.flags
    assert all(start.converged and start.steps < 20 for start in found.starts)
    assert found["gap"].error is not None
