"""A fit put together by hand: its numbers are chosen, so that what is said of them can be checked word by word."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import cast

import numpy as np
import pytest

from ident.campaign import Campaign, Channel, NoiseFloor, Oscillator, Platform, Trace
from ident.campaign.device import Device
from ident.effects.registry import built_in
from ident.fit.identifiability import Combination
from ident.fit.judge import score_record
from ident.fit.linear.guess import DataScales
from ident.fit.result import Estimate, Fit, Solved, Start
from ident.fit.uncertainty import Covariance, Linearisation
from ident.model import Model

SIGMA = 2e-8


def sine_trace(
    name: str, level: float, frequency: float, offset: float = 0.0, samples: int = 1600, per_period: float = 50.0
) -> Trace:
    """A sine drive and a response of 1 µm/V that lags by 0.5 rad, with a mean and known noise."""
    step = 1.0 / (frequency * per_period)
    time = np.arange(samples) * step
    angle = 2 * np.pi * frequency * time
    noise = np.random.default_rng(len(name)).normal(0.0, SIGMA, samples)
    response = offset + level * 1e-6 * np.sin(angle - 0.5) + noise
    volt, um = Channel("V", 1.0), Channel("µm", 1e-6)
    floor = NoiseFloor(SIGMA, method="given in the campaign")
    return Trace(name, time, level * np.sin(angle), response, volt, um, floor, start="rest", period=per_period)


def clean(trace: Trace, misfit: float = 0.0) -> np.ndarray:
    """What a perfect model would read, wrong by `misfit` of the response."""
    level = round(float(np.max(trace.drive)))
    turn = 2 * np.pi / (trace.period or 1.0) * np.arange(len(trace.time))
    return (1 + misfit) * level * 1e-6 * np.sin(turn - 0.5)


@dataclass(frozen=True)
class Maker:
    """Builds fits: change what a test is about, leave the rest."""

    def __call__(
        self,
        *,
        device: Device | None = None,
        effects: tuple[str, ...] = ("residual-stress", "pzt-hysteresis"),
        settings: dict[str, str] | None = None,
        misfit: float = 0.0,
        heldout_misfit: float = 0.0,
        traces: tuple[Trace, ...] | None = None,
        **changed: object,
    ) -> Fit:
        device = Platform() if device is None else device
        library = built_in()
        model = Model(device, tuple(library[n](device, settings if n == "residual-stress" else None) for n in effects))
        if traces is None:
            heldout = replace(sine_trace("held_out_5V.csv", 5.0, 450.0), holdout=True)
            traces = (sine_trace("first_8V.csv", 8.0, 317.0), sine_trace("second_3V.csv", 3.0, 500.0), heldout)
        readings = tuple(clean(t, heldout_misfit if t.holdout else misfit) for t in traces)
        estimates = tuple(_estimate(p.name, p.unit, p.fitted) for p in model.parameters)
        free = tuple(i for i, e in enumerate(estimates) if e.fitted)
        p = len(free)
        errors = np.array([estimates[i].standard_error or 1.0 for i in free])
        fit = Fit(
            model=model,
            campaign=Campaign("two sines", traces, device, checksums={"first_8V.csv": "ab" * 32}),
            values=np.array([e.value for e in estimates]),
            estimates=estimates,
            free=free,
            covariance=np.diag(errors**2),
            combinations=_combinations(effects),
            readings=readings,
            scores=tuple(score_record(t, r) for t, r in zip(traces, readings, strict=True)),
            starts=(Start(120.0, 1.0, 9, True), Start(150.0, 1.0000001, 11, True)),
            sigma="known",
            converged=True,
            scales=DataScales(8e-6, 1e-2, 8.0, 2e-3, 0.1, 2e4),
            spectrum=Covariance(np.eye(p), np.zeros((p, 0)), np.ones(p), np.ones(p), np.eye(p)),
            linear=Linearisation(np.zeros((4, p)), np.zeros(4), np.eye(p)),
            solved=cast(Solved, None),  # no page looks at the arrays
        )
        step_error = changed.pop("step_error", 0.02)
        fit = replace(fit, **changed)  # type: ignore[arg-type]
        fit.__dict__.update(step_error=step_error, begun_otherwise=[])  # else they would be simulated
        return fit


_NUMBERS = {
    "frequency": (498.5995, 0.00057),
    "quality": (31.007, 0.0032),
    "d31": (6.399e-11, 4.6e-15),
    "gain": (190000.17, 2.86),
    "k3": (60001.0, 2.06),
    "sigma12": (106.66e6, None),
    "sigma23": (9.22e6, None),
    "restraint": (0.37998, 4.6e-5),
    "voltage_force": (1e-5, 7e-6),
    "eta": (2.19991e-23, 1.41e-26),
    "zeta": (1.3e-27, 1.5e-26),
}
_FLAGGED = {"sigma12": ("undetermined",), "sigma23": ("undetermined",), "zeta": ("not-significant",)}


def _estimate(name: str, unit: str, fitted: bool) -> Estimate:
    short = name.rpartition(".")[2]
    value, error = _NUMBERS.get(short, (0.0, None))
    flags = _FLAGGED.get(short, ()) if fitted else ("held",)
    return Estimate(name, value, error if fitted else None, unit, fitted, flags)


def _combinations(effects: tuple[str, ...]) -> tuple[Combination, ...]:
    if "residual-stress" not in effects:
        return ()
    names = ("residual-stress.sigma12", "residual-stress.sigma23")
    return (Combination(names, (0.8107, 0.5854), 74.391e6, 0.098e6, "Pa", False),)


@pytest.fixture
def make_fit() -> Maker:
    return Maker()


@pytest.fixture
def oscillator_fit() -> Fit:
    return Maker()(device=Oscillator("V", "V"), effects=("cubic-stiffness",))
