"""Where a campaign does not say which law of an effect is meant, the records do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import ident
from experiments.simulator.signals import multisine, sine
from experiments.simulator.stage import Stage, simulate
from ident.campaign.campaign import Campaign
from ident.diagnosis.search.change import add
from ident.effects.registry import built_in
from ident.model import open_words
from ident.report.words.sentences import sentences

STRESSED = Stage(505.0, 40.0, 55e-12, closure="sign-change", sigma12=90e6, restraint=3.0, width=4e-6)
TONES = np.array([180.0, 250.0, 330.0, 410.0, 480.0, 520.0])


@pytest.fixture(scope="module")
def records() -> Campaign:
    rng, time, found = np.random.default_rng(5), np.arange(2400) / 12e3, []
    drives = (sine(8.0, 317.0), sine(4.0, 500.0), multisine(9.0, TONES, 1), sine(7.0, 508.0), multisine(6.0, TONES, 2))
    for k, drive in enumerate(drives):
        z = simulate(STRESSED, drive, time)[0]
        read = z + 0.004 * np.std(z) * rng.normal(size=len(time))
        table = {"time": time, "drive": drive.value(time), "response": read}
        found.append({"data": table, "start": "rest", "holdout": k == len(drives) - 1})
    return ident.read_campaign({"record": found})


def test_the_sharp_change_of_stiffness_is_residual_stress_too(records: Campaign) -> None:
    """With the usual closure alone it went unnamed: a bilinear spring and a hysteresis stood in its place."""
    found = ident.discover(records)
    assert found.discovery.steps[0].added == "residual-stress"
    assert found.final.model.effects[-1].settings == {"closure": "sign-change"}
    assert found.final.fitted.error_over_noise == pytest.approx(1.0, abs=0.05)
    assert found.final.holdout is not None and found.final.holdout.error_over_noise == pytest.approx(1.0, abs=0.1)
    assert any('closure = "sign-change"' in one.text for one in sentences(found.final))


def test_what_the_campaign_says_is_kept(records: Campaign) -> None:
    stress = built_in()["residual-stress"]
    told = replace(records, settings={"residual-stress": {"closure": "axial-force"}})
    assert open_words(told, stress) == [{}]
    assert [words["closure"] for words in open_words(records, stress)] == ["axial-force", "sign-change", "frame"]
    assert add(ident.fit(told, effects=()), stress, most=3).model.effects[-1].settings == {"closure": "axial-force"}
