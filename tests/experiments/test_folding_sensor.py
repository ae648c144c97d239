"""A sensor that reads a tenth of the motion at resonance, as it does of a tenth of it."""

from __future__ import annotations

import pytest

from experiments.curves.files import STYLES, write
from experiments.curves.generator import Noise, draw
from ident.campaign import read_campaign
from ident.fit import fit
from ident.model import build_model


def test_a_search_does_not_go_on_from_the_motions_of_a_trial_that_it_refused(tmp_path):
    case = draw(9824, ("sensor-nonlinearity",), size=0.3, noise=Noise())
    write(case, tmp_path, STYLES[0], True)
    campaign = read_campaign(tmp_path)
    found = fit(build_model(campaign, ("sensor-nonlinearity",)), campaign)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.1)
    for name in ("frequency", "quality"):
        true = case.truth["parameters"][f"platform.{name}"]
        assert abs(found[name].value - true) < 4 * found[name].error
