"""A sensor that reads a tenth of the motion at resonance, as it does of a tenth of it."""

from __future__ import annotations

import pytest

from experiments.curves.folding import fitted


def test_a_search_does_not_go_on_from_the_motions_of_a_trial_that_it_refused():
    case, found = fitted(9824, phase=True)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.1)
    for name in ("frequency", "quality"):
        true = case.truth["parameters"][f"platform.{name}"]
        assert abs(found[name].value - true) < 4 * found[name].error
