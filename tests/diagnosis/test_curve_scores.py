"""The effect that sweeps lack is named from the linear model, with its size; traces are not needed."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.linearised.trajectory import Diverged
from ident.diagnosis.ranking.confirm import confirm
from ident.diagnosis.ranking.score import kept_more_than_chance, score
from ident.diagnosis.ranking.weigh import Candidate
from ident.diagnosis.where.locate import locate
from ident.effects.effect import AbstractEffect, Drive, Scalar, State, amplitude
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model
from tests.fit.test_curves import CUBIC, FREQUENCY, sweep

NAMES = ("cubic-stiffness", "quadratic-damping", "sensor-crosstalk", "prandtl-ishlinskii", "static-force")


def test_a_missing_spring_is_named_with_its_size() -> None:
    device = Oscillator(output="m")
    campaign = Campaign("", (sweep(0.2, CUBIC, True, 3, 3e-5), sweep(0.5, CUBIC, True, 1, 3e-4)), device)
    linear = fit(Model(device), campaign)
    assert linear.fitted.error_over_noise > 10
    regression = prepare(linear)
    found = score(regression, {name: built_in()[name] for name in NAMES})
    assert found[0].name == "cubic-stiffness"
    assert found[0].predicted_gain > 0.99
    assert found[0].values["k3"] == pytest.approx(CUBIC, rel=0.15)
    assert "static-force" not in [one.name for one in found], "a constant force does not reach the fundamental"
    assert locate(regression).fails


def test_a_drive_that_depends_on_no_amplitude_explains_no_curve() -> None:
    """Friction and hardly any device beside it need the same drive everywhere, as was measured at one level."""
    device = Oscillator(output="m")
    campaign = Campaign("", (sweep(0.5, CUBIC, False, 1, 3e-4),), device)
    regression = prepare(fit(Model(device), campaign))
    found = score(regression, {name: built_in()[name] for name in ("coulomb-friction", "cubic-stiffness")})
    assert found[0].name == "cubic-stiffness"
    assert found[0].predicted_gain > 0.9


def test_noise_of_amplitudes_is_no_law_of_the_actuator() -> None:
    """A gain that grows and plays that take it off again leave the noise where it is."""
    device = Oscillator(output="m")
    model = Model(device) + built_in()["cubic-stiffness"](device)
    campaign = Campaign("", tuple(sweep(level, CUBIC, True, 5, 3e-4) for level in (0.1, 0.2, 0.5)), device)
    regression = prepare(fit(model, campaign))
    assert regression.chi2 < 1.3 * regression.n
    (found,) = score(regression, {"prandtl-ishlinskii": built_in()["prandtl-ishlinskii"]})
    assert found.drop < 20  # three numbers: 1 in 5000 by chance


@pytest.mark.parametrize("phase", [True, False])
def test_an_even_spring_is_scored_by_what_its_mean_and_its_overtone_do(phase: bool) -> None:
    """It softens as a cubic one of −(10/9) k2²/ω0² (Nayfeh & Mook, Nonlinear Oscillations, 1979, §2.3.1)."""
    device = Oscillator(output="m")
    campaign = Campaign("", (sweep(0.1, -CUBIC, phase, 3, 3e-5), sweep(0.3, -CUBIC, phase, 1, 3e-5)), device)
    linear = fit(Model(device), campaign)
    assert linear.fitted.error_over_noise > 10
    found = {
        one.name: one
        for one in score(prepare(linear), {n: built_in()[n] for n in ("quadratic-stiffness", "cubic-stiffness")})
    }
    even, odd = found["quadratic-stiffness"], found["cubic-stiffness"]
    assert even.predicted_gain > 0.95 and odd.predicted_gain > 0.95
    equal = np.sqrt(0.9 * (2 * np.pi * FREQUENCY) ** 2 * abs(odd.values["k3"]))
    assert abs(even.values["k2"]) == pytest.approx(equal, rel=0.03)


@pytest.mark.parametrize("name", ["drive-lag", "sensor-lag"])
def test_a_lag_is_scored_by_its_square_where_phases_were_not_measured(name: str) -> None:
    """It turns the response by ωτ, which amplitudes do not show, and makes it smaller by √(1 + ω²τ²), which they do."""
    device, late = Oscillator(output="m"), 0.4 / (2 * np.pi * FREQUENCY)
    seen = [sweep(level, 0.0, False, 3, 3e-6) for level in (0.2, 0.5)]
    slower = [1 / np.sqrt(1 + (2 * np.pi * one.frequency * late) ** 2) for one in seen]
    told = [replace(one, amplitude=one.amplitude * by) for one, by in zip(seen, slower, strict=True)]
    linear = fit(Model(device), Campaign("", tuple(told), device))
    assert linear.fitted.error_over_noise > 2
    (found,) = score(prepare(linear), {name: built_in()[name]})
    assert found.predicted_gain > 0.8
    assert abs(found.values["time"]) == pytest.approx(late, rel=0.25)


def test_an_amplitude_that_no_curve_shows_is_left_at_zero() -> None:
    """Of a sensor that bends the even part adds a mean and an overtone; a search would take it as far as it likes. One
    that saturates below what was read has no motion: there the refit begins with little of the effect."""
    device = Oscillator(output="m")
    seen = [sweep(level, 0.0, False, 3, 3e-6) for level in (0.1, 0.2, 0.3)]
    largest = max(float(np.max(one.amplitude)) for one in seen)
    bent = lambda a: a - 0.2 * a**3 / largest**2 / (1 + 0.3 * (a / largest) ** 2)
    told = tuple(replace(one, amplitude=bent(one.amplitude)) for one in seen)
    regression = prepare(fit(Model(device), Campaign("", told, device)))
    effect = built_in()["sensor-nonlinearity"]
    (found,) = score(regression, {effect.name: effect})
    assert found.unseen == {"quadratic"}
    far = confirm(
        regression, effect, found._replace(values={**found.values, "cubic": 3 * found.values["cubic"]}, near=())
    )
    assert "sensor-nonlinearity.quadratic" in far.model.held
    for one in (confirm(regression, effect, found), far):
        values = dict(zip((p.name for p in one.model.parameters), one.values, strict=True))
        assert one.chi2 < 1.5 * regression.n and values["sensor-nonlinearity.quadratic"] == 0.0


class Bent(AbstractEffect):
    """A spring that hardens by a cubic part and softens by a quadratic one, more the larger it is."""

    name = "bent"
    equation = "F = −s (k z³ + q z²)"
    source = "this test"

    share = amplitude("1", "its size", positive=True)
    EVEN = np.sqrt(0.75 * 0.9 * (2 * np.pi * FREQUENCY) ** 2 * CUBIC)  # at s = 2 as a cubic spring of −k together

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.share * (CUBIC * state.z + self.EVEN) * state.z**2


@pytest.mark.parametrize("phase", [True, False])
def test_an_odd_part_does_not_hide_what_an_even_one_does(phase: bool) -> None:
    """To first order it hardens, and a device that softens would ask for a size that cannot be."""
    device = Oscillator(output="m")
    campaign = Campaign("", (sweep(0.1, -CUBIC, phase, 3, 3e-5), sweep(0.3, -CUBIC, phase, 1, 3e-5)), device)
    (found,) = score(prepare(fit(Model(device), campaign)), {"bent": Bent})
    assert found.predicted_gain > 0.95
    assert found.values["share"] == pytest.approx(2.0, rel=0.03)


def test_a_refit_that_keeps_what_chance_would_give_is_no_effect() -> None:
    """Without phases a lag of the sensor promised 31.9 of 320 points of noise by its square, and its refit kept 7.6."""
    columns = np.linalg.qr(np.random.default_rng(1).normal(size=(320, 4)))[0]
    asked = (type(f"Effect{i}", (), {"name": f"effect-{i}"}) for i in range(25))
    told = SimpleNamespace(n=320, best_chi2=323.1, absorbed=columns[:, :3], scored=dict.fromkeys(asked, "a candidate"))
    lag = Candidate("sensor-lag", 31.9, 1.0, 1, 7e-11, {}, {}, {}, columns[:, 3:].T)
    kept = lambda chi2: kept_more_than_chance(lag, chi2, told)  # pyright: ignore[reportArgumentType]  (what it reads)
    assert kept(323.1 - 31.9)
    assert not kept(323.1 - 7.6)
    assert not kept(323.2)


def test_a_model_that_no_drive_makes_answer_is_told_as_one_without_a_motion() -> None:
    """Two lags that undo one another had ended so, and the walk with them."""
    device = Oscillator(output="m")
    fitted = fit(Model(device), Campaign("", (sweep(0.2, CUBIC, True, 3, 3e-5),), device))
    steady = fitted.solved.found.steady
    assert steady is not None
    none = replace(steady, unknowns=np.full_like(steady.unknowns, np.nan))
    solved = fitted.solved._replace(found=fitted.solved.found._replace(steady=none))
    with pytest.raises(Diverged):
        prepare(replace(fitted, solved=solved))


class Heavier(AbstractEffect):
    """A mass that moves along more at either end of the path."""

    name, equation, source = "heavier", "F = −m2 (z² z̈ + z ż²)", "a test"
    curvature = amplitude("kg/m^2", "mass per squared displacement")

    def inertia(self, z: Scalar) -> Scalar:
        return self.curvature * z**2

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.curvature * state.z * state.v**2


class Tilted(AbstractEffect):
    """One that moves along more at one end than at the other."""

    name, equation, source = "tilted", "F = −m1 (z z̈ + ż²/2)", "a test"
    slope = amplitude("kg/m", "mass per displacement")

    def inertia(self, z: Scalar) -> Scalar:
        return self.slope * z

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.slope / 2 * state.v**2


@pytest.mark.parametrize("law", [Heavier, Tilted])
def test_an_inertia_that_changes_is_scored_as_the_spring_whose_resonance_bends_as_much(
    law: type[AbstractEffect],
) -> None:
    """ω = ω0 (1 − m2 a²/4) and ω0 (1 + m1² a²/16): the free motion in a coordinate of constant mass, ∫ √(1 + m) dz."""
    device = Oscillator(output="m")
    campaign = Campaign("", (sweep(0.1, CUBIC, True, 3, 3e-5), sweep(0.3, CUBIC, True, 1, 3e-5)), device)
    (found,) = score(prepare(fit(Model(device), campaign)), {law.name: law})
    own = (2 * np.pi * FREQUENCY) ** 2
    size = {"curvature": -1.5 * CUBIC / own, "slope": (6 * CUBIC / own) ** 0.5}
    assert found.predicted_gain > 0.97
    for name, value in found.values.items():
        assert (abs(value) if name == "slope" else value) == pytest.approx(size[name], rel=0.15)
