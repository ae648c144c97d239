"""Profiles: what the data leave open is called open, and what only a bound closes is one-sided."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from ident.campaign import Campaign, Channel, NoiseFloor, Platform, Trace
from ident.effects import AbstractEffect, amplitude
from ident.effects.registry import built_in
from ident.errors import UserError
from ident.fit import fit
from ident.fit.profile import check_profiled, profile
from ident.fit.reading import read
from ident.fit.rebuild import fit_at
from ident.model import Model

N, SIGMA = 600, 25e-9


@pytest.fixture(scope="module")
def linear() -> Campaign:
    """One short record of the linear platform."""
    time = np.arange(N) / 25e3
    record = Trace("a.csv", time, 6 * np.sin(2 * np.pi * 480 * time), np.zeros(N), Channel("V", 1.0),
                   Channel("um", 1e-6), NoiseFloor(SIGMA), start="rest")  # fmt: skip
    model = Model(Platform())
    (reading,) = read(model, np.array([503.0, 35.0, 30e-12]), [record])
    measured = reading + np.random.default_rng(3).normal(0.0, SIGMA, N)
    return Campaign("linear", (Trace(**{**vars(record), "response": measured}),))


class Drag(AbstractEffect):
    """Drag that cannot push: F = −c |v| v, c > 0."""

    name = "drag"
    c = amplitude("N*s^2/m^2", positive=True, default=1e-3)

    def force(self, state, drive, t):
        return -self.c * jnp.abs(state.v) * state.v


class SecondSpring(AbstractEffect):
    """A spring beside the spring: F = −k z."""

    name = "second-spring"
    k = amplitude("N/m", default=1.0)

    def force(self, state, drive, t):
        return -self.k * state.z


def test_a_nearly_linear_model_is_closed_and_agrees_with_its_error_bar(linear):
    found = fit(Model(Platform(), (built_in()["cubic-stiffness"](),)), linear)
    result = profile(found, "cubic-stiffness.k3")
    error = next(e for e in found.estimates if e.name == "cubic-stiffness.k3").standard_error
    assert result.kind == "closed" and result.better is None
    assert result.high - result.low == pytest.approx(2 * error, rel=0.05)
    assert "closed" in result.sentence


def test_a_drag_that_is_not_there_has_an_upper_limit_only(linear):
    result = profile(fit(Model(Platform(), (Drag(),)), linear), "drag.c")
    assert result.kind == "one-sided" and result.low is None and result.high > 0
    assert "without lower limit" in result.sentence


def test_two_springs_in_one_place_are_flat(linear):
    result = profile(fit(Model(Platform(), (SecondSpring(),)), linear), "second-spring.k")
    assert result.kind == "flat" and (result.low, result.high) == (None, None)
    assert result.as_dict()["kind"] == "flat"


def test_a_better_optimum_on_the_way_is_reported(linear):
    found = fit(Model(Platform()), linear)
    index = [p.name for p in found.model.parameters].index("platform.quality")
    error = found.estimates[index].standard_error
    worse = fit_at(found.model, linear, found.values + 2 * error * np.eye(3)[index])
    result = profile(worse, "quality")
    assert result.better is not None and result.better[index] == pytest.approx(found.values[index], abs=error)
    assert result.name == "platform.quality" and "A better optimum" in result.sentence


def test_what_is_not_fitted_has_no_profile():
    model = Model(Platform(), (built_in()["residual-stress"](),))
    with pytest.raises(UserError, match=r"did you mean 'residual-stress\.sigma12'"):
        check_profiled(model, ["residual-stress.sigma_12"])
    with pytest.raises(UserError, match="is held"):
        check_profiled(model, ["residual-stress.sigma2"])
    check_profiled(model, ["quality", "sigma12"])
