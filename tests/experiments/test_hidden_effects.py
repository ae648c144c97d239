"""The hidden-effect generator solves what it says, and its devices are as hard as they claim."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from experiments.hidden_effects import generator, laws
from experiments.simulator.signals import sine

LIBRARY = {
    "bilinear-stiffness",
    "force-factor",
    "variable-inertia",
    "residual-stress",
    "arch-force",
    "cubic-stiffness",
    "quadratic-stiffness",
    "voltage-stiffness",
    "stiffness-drift",
    "end-stop",
    "static-force",
    "second-mode",
    "viscoelastic-support",
    "coulomb-friction",
    "quadratic-damping",
    "cubic-damping",
    "squeeze-film-damping",
    "damping-drift",
    "bouc-wen",
    "pzt-hysteresis",
    "prandtl-ishlinskii",
    "bouc-wen-drive",
    "electrostriction",
    "electrostatic-force",
    "creep",
    "drive-lag",
    "sensor-nonlinearity",
    "sensor-lag",
    "sensor-crosstalk",
    "sensor-drift",
    "sensor-offset",
    "power-law-stiffness",
    "power-law-damping",
    "stribeck-friction",
    "stiffness-heating",
    "damping-heating",
    "drive-heating",
}
SHARP = {
    "coulomb-friction",
    "power-law-damping",
    "stribeck-friction",
    "end-stop",
    "bouc-wen",
    "bouc-wen-drive",
    "prandtl-ishlinskii",
}
STRENGTH = {"residual-stress": 0.5, "arch-force": 4.0, "coulomb-friction": 5e-4, "stribeck-friction": 5e-4}


def _device() -> generator.Device:
    return generator.Device("platform", 500.0, 35.0, 1 / 14, 20e-6, 9.0, span=599 / 40000)


def _coefficients(name: str) -> tuple[np.ndarray, np.ndarray]:
    c, s = np.zeros(len(laws.LAWS)), np.zeros((len(laws.LAWS), 3))
    c[laws.INDEX[name]] = STRENGTH.get(name, 0.03)
    s[laws.INDEX[name]] = laws.LAWS[laws.INDEX[name]].shape(np.random.default_rng(5), True)
    return c, s


def _plan(samples: int = 600) -> generator.Plan:
    return generator.Plan("sine", sine(9.0, 490.0), np.arange(samples) / 40000, 0, False)


def test_every_library_effect_and_some_outside_it() -> None:
    inside = {law.name for law in laws.LAWS if law.in_library}
    assert inside == LIBRARY
    assert len(laws.LAWS) - len(inside) >= 3


@pytest.mark.parametrize("law", laws.LAWS, ids=laws.NAMES)
def test_steps_are_fine_enough(law: laws.Law) -> None:
    c, s = _coefficients(law.name)
    coarse, fine = (generator.respond(_plan(), _device(), c, s, n)[0] for n in (8, 32))
    plain = generator.respond(_plan(), _device(), 0 * c, s, 8)[0]
    assert np.max(np.abs(coarse - fine)) < (1e-4 if law.name in SHARP else 2e-5) * np.max(np.abs(fine))
    assert np.max(np.abs(coarse - plain)) > 3e-4 * np.max(np.abs(fine))  # and the effect is there


@pytest.mark.parametrize("law", [x for x in laws.LAWS if x.side == "force"], ids=lambda x: x.name)
def test_steps_agree_with_an_adaptive_solver(law: laws.Law) -> None:
    plan, device, (c, s) = _plan(300), _device(), _coefficients(law.name)
    w0, span, out = 2 * np.pi * device.frequency, device.span, np.empty(laws.STATES)

    def rate(tau: float, x: np.ndarray) -> np.ndarray:
        e = float(plan.drive.value(np.array([tau / w0]))[0]) / device.volts
        laws.rate(x, device.gain * e, e, tau / w0 / span, c, s, device.geometry, device.quality, out)
        return out.copy()

    tau = plan.t * w0
    found = solve_ivp(rate, (0, tau[-1]), np.zeros(laws.STATES), "DOP853", tau, rtol=1e-9, atol=1e-12, max_step=0.1)
    exact = found.y[0] + c[laws.MODE] * found.y[5]
    made = generator.respond(plan, device, c, s, 8)[0]
    assert np.max(np.abs(made - exact)) < (1e-4 if law.name in SHARP else 1e-6) * np.max(np.abs(exact))


def test_lag_and_creep_are_their_differential_equation() -> None:
    h, tau, w = 0.005, 0.3, 0.9
    t = np.arange(4000) * h
    exact = (np.sin(w * t) - w * tau * (np.cos(w * t) - np.exp(-t / tau))) / (1 + (w * tau) ** 2)
    np.testing.assert_allclose(laws.lag(np.sin(w * t), h, tau), exact, atol=1e-5)


@pytest.mark.parametrize(
    ("effects", "device", "starts"),
    [
        (("cubic-stiffness",), "platform", "rest"),
        (("sensor-lag",), "oscillator", "mixed"),
        (("creep", "end-stop"), "platform", "mixed"),
        ((), "oscillator", "rest"),
    ],
)
def test_a_device_is_as_hard_as_it_claims(effects, device, starts) -> None:
    case = generator.draw(3, effects, size=0.02, noise=0.01, device=device, starts=starts)
    again = generator.draw(3, effects, size=0.02, noise=0.01, device=device, starts=starts)
    for law in case.truth["laws"].values():
        assert law["size"] == pytest.approx(0.02, rel=0.03)
    if not effects:
        assert case.truth["size"] < 1e-6
    assert sum(not r.holdout for r in case.records) == 6
    assert {r.start for r in case.records} == ({"rest", "unknown"} if starts == "mixed" else {"rest"})
    for record, twin in zip(case.records, again.records, strict=True):
        np.testing.assert_array_equal(record.response, twin.response)
        assert np.std(record.response - record.clean) == pytest.approx(0.01 * np.std(record.clean), rel=0.08)


@pytest.mark.parametrize("kind", ["white", "ar", "hum"])
def test_noise_has_the_stated_size(kind) -> None:
    case = generator.draw(8, (), noise=0.01, noise_kind=kind, length=4000)
    ratios = [np.std(r.response - r.clean) / r.sigma for r in case.records]
    assert np.mean(ratios) == pytest.approx(1, abs=0.1)


def test_the_truth_is_kept_apart(tmp_path: Path) -> None:
    case = generator.draw(1, ("electrostriction",), length=400)
    generator.write(case, tmp_path / "campaign", tmp_path / "truth" / "1.json")
    written = tomllib.loads((tmp_path / "campaign" / "campaign.toml").read_text(encoding="utf-8"))
    assert written["model"]["effects"] == [] and len(written["record"]) == 10
    assert "electrostriction" not in "".join(f.read_text(encoding="utf-8") for f in (tmp_path / "campaign").iterdir())
    assert json.loads((tmp_path / "truth" / "1.json").read_text(encoding="utf-8"))["effects"] == ["electrostriction"]
    table = np.genfromtxt(tmp_path / "campaign" / "multisine.csv", delimiter=",", skip_header=1).T
    made = next(r for r in case.records if r.name == "multisine")
    np.testing.assert_allclose(table[2] * 1e-6, made.response, atol=0.1 * made.sigma)
