"""The effect that sweeps lack is named from the linear model, with its size; traces are not needed."""

from __future__ import annotations

import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.diagnosis.bench import prepare
from ident.diagnosis.locate import locate
from ident.diagnosis.score import score
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model
from tests.fit.test_curves import CUBIC, sweep

NAMES = ("cubic-stiffness", "quadratic-damping", "sensor-crosstalk", "prandtl-ishlinskii", "static-force")


def test_a_missing_spring_is_named_with_its_size() -> None:
    device = Oscillator(output="m")
    campaign = Campaign("", (sweep(0.2, CUBIC, True, 3, 3e-5), sweep(0.5, CUBIC, True, 1, 3e-4)), device)
    linear = fit(Model(device), campaign)
    assert linear.fitted.error_over_noise > 10
    bench = prepare(linear)
    found = score(bench, {name: built_in()[name] for name in NAMES})
    assert found[0].name == "cubic-stiffness"
    assert found[0].predicted_gain > 0.99
    assert found[0].values["k3"] == pytest.approx(CUBIC, rel=0.15)
    assert "static-force" not in [one.name for one in found], "a constant force does not reach the fundamental"
    assert locate(bench).fails


def test_a_drive_that_depends_on_no_amplitude_explains_no_curve() -> None:
    """Friction and hardly any device beside it need the same drive everywhere, as was measured at one level."""
    device = Oscillator(output="m")
    campaign = Campaign("", (sweep(0.5, CUBIC, False, 1, 3e-4),), device)
    bench = prepare(fit(Model(device), campaign))
    found = score(bench, {name: built_in()[name] for name in ("coulomb-friction", "cubic-stiffness")})
    assert found[0].name == "cubic-stiffness"
    assert found[0].predicted_gain > 0.9
