"""What effects add to the readings: a memory that does not change is followed once, and says the same."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.campaign.device import Platform
from ident.diagnosis.linearised import columns
from ident.diagnosis.linearised.regression import Regression, prepare, stack
from ident.diagnosis.linearised.trajectory import Diverged
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.rebuild import fit_at
from ident.model import Model
from ident.response import Equation


@pytest.fixture(scope="module")
def regression() -> Regression:
    campaign = campaign_of(draw(71, ("cubic-stiffness",), size=0.02, noise=0.003, records=3, length=400))
    return prepare(fit(Model(campaign.device), campaign))


@pytest.mark.parametrize("name", ["creep", "bouc-wen"])
def test_a_memory_that_no_amplitude_bends_is_followed_without_tangents(
    name: str, regression: Regression, monkeypatch: pytest.MonkeyPatch
) -> None:
    effect = built_in()[name]()
    model = Model(regression.fit.model.device, (effect,))
    names = [p.name for p in model.parameters]
    shapes = {f"{name}.{p.name}": abs(p.grid[0]) for p in effect.declared() if p.kind == "shape"}
    sizes = {"displacement": regression.fit.scales.displacement, "duration": regression.fit.scales.duration}
    scales = {f"{name}.{p.name}": sizes.get(p.scale, 1.0) for p in effect.declared() if p.kind == "shape"}
    own = {**dict(zip(names, regression.fit.values, strict=False)), **{n: shapes[n] * scales[n] for n in shapes}}
    values = np.array([own.get(n, 0.0) for n in names])
    amplitudes = [i for i, p in enumerate(model.parameters) if i > 2 and p.kind == "amplitude"]
    directions = np.eye(len(names))[amplitudes]
    asked = columns.Terms(Equation(model), False)
    assert not asked.along(directions).bent
    assert asked.along(np.eye(len(names))).bent
    plain = stack(regression, model, values[None], directions)
    assert np.all(np.ptp(plain, axis=1) > 0)
    monkeypatch.setattr(columns, "_bend", lambda equation, moved: True)
    bent = stack(regression, model, values[None], directions)
    np.testing.assert_allclose(plain, bent, rtol=1e-10, atol=1e-12 * float(np.max(np.abs(bent))))


def test_a_memory_bends_with_what_it_depends_on_alone() -> None:
    library = built_in()
    plays = Equation(Model(Platform(), (library["prandtl-ishlinskii"](),)))
    assert not columns._bend(plays, frozenset({"prandtl-ishlinskii.weight", "prandtl-ishlinskii.tilt"}))
    assert columns._bend(plays, frozenset({"prandtl-ishlinskii.reach"}))
    assert columns._bend(plays, frozenset({plays.model.parameters[2].name}))  # the gain, which a memory may see
    spring = Equation(Model(Platform(), (library["cubic-stiffness"](),)))
    assert not columns._bend(spring, frozenset(p.name for p in spring.model.parameters))


def test_a_model_that_runs_away_beside_the_measured_motion_is_no_model(regression: Regression) -> None:
    """Friction that drives, as a refit without another effect may end with: LAPACK was given what is no number."""
    fitted = regression.fit
    driven = fitted.model + built_in()["coulomb-friction"]()
    values = np.append(fitted.values, [-0.1, 1e-3])
    with np.errstate(all="ignore"), pytest.raises(Diverged):
        prepare(fit_at(driven, fitted.campaign, values))
