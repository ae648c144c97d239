"""A platform's sensor whose zero is off by more than any law moves the stage: it is named first, and hides nothing."""

from __future__ import annotations

from dataclasses import replace

import pytest

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.campaign.campaign import Campaign
from ident.diagnosis.diagnose import diagnose
from ident.diagnosis.search.steps import Walked
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model


@pytest.fixture(scope="module", params=[0.3, 3.0])
def campaign(request: pytest.FixtureRequest) -> Campaign:
    """Sines from rest on a platform with a cubic spring that makes some seven noise floors, read off zero by so much of
    the largest displacement."""
    case = draw(45, ("cubic-stiffness",), size=0.02, noise=0.003, records=4, length=1200)
    off = request.param * max(abs(record.response).max() for record in case.records)
    told = campaign_of(case)
    return replace(told, records=tuple(replace(r, response=r.response + off) for r in told.traces))


def test_what_an_offset_dwarfs_is_an_effect_of_its_own(campaign: Campaign) -> None:
    """It had been a play that mimicked the offset, or a cubic spring that "only refines its shape"."""
    start = fit(Model(campaign.device), campaign)
    kept: list[Walked] = []
    found = diagnose(start, keep=kept.append)
    first, second = found.discovery.steps
    assert (first.added, first.role, first.tie_set) == ("sensor-offset", "effect", ("sensor-offset",))
    assert (second.added, second.role) == ("cubic-stiffness", "effect")
    assert found.verdict != "not-in-library" and found.final.fitted.error_over_noise < 1.1
    assert found.discovery.start.model.names == () and found.discovery.ranking[0].name == "sensor-offset"
    assert kept and all(walked.steps[0].added == "sensor-offset" for walked in kept)
    assert kept[0].start.model.names == ()
    again = diagnose(kept[-1])
    assert [s.added for s in again.discovery.steps] == ["sensor-offset", "cubic-stiffness"]


def test_an_offset_alone_is_identified_and_none_where_there_is_none() -> None:
    library = {name: built_in()[name] for name in ("sensor-offset", "quadratic-damping", "voltage-stiffness")}
    still = draw(45, (), size=0.02, noise=0.003, records=4, length=1200)
    told = campaign_of(still)
    off = 0.1 * max(abs(record.response).max() for record in still.records)
    moved = replace(told, records=tuple(replace(r, response=r.response + off) for r in told.traces))
    found = diagnose(fit(Model(moved.device), moved), library)
    assert [s.added for s in found.discovery.steps] == ["sensor-offset"] and found.verdict == "identified"
    assert diagnose(fit(Model(told.device), told), library).verdict == "adequate"
