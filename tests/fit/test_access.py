"""A fit in Python: parameters by name, tables with names, a short face, and a copy that survives a pickle."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from ident.campaign import read_campaign
from ident.errors import UserError
from ident.fit import fit
from ident.model import build_model
from tests.end_to_end.user import DATA


@pytest.fixture(scope="module")
def found():
    campaign = read_campaign(DATA / "platform_clean")
    return fit(build_model(campaign), campaign)


def test_parameters_by_name_and_did_you_mean(found):
    quality = found["quality"]
    assert quality == found["platform.quality"] and abs(quality.value - 35) < 5 * quality.error
    with pytest.raises(UserError, match="did you mean 'quality'"):
        found["qualty"]


def test_tables_carry_names_and_say_what_the_fit_says(found):
    table = found.to_dataframe()
    assert table.loc["platform.quality", "value"] == found.value("platform.quality")
    errors = np.sqrt(np.diag(found.labelled_covariance))
    np.testing.assert_allclose(errors, table.loc[found.labelled_covariance.index, "error"], rtol=1e-6)
    for score, residual in zip(found.scores, found.residuals.values(), strict=True):
        record = next(r for r in found.campaign.traces if r.name == score.name)
        ratio = np.sqrt(np.mean(residual[record.skip :] ** 2)) / record.noise.sigma
        assert abs(ratio - score.error_over_noise) < 0.02


def test_a_short_face_and_a_copy(found):
    assert repr(found).startswith("<Fit of the linear model alone: error over noise 1") and len(repr(found)) < 120
    assert "platform.quality" in found._repr_html_() and "<table>" in found._repr_html_()
    copy = pickle.loads(pickle.dumps(found))
    np.testing.assert_array_equal(copy.values, found.values)
    assert repr(copy) == repr(found)
