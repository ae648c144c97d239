"""A sensor of velocity or acceleration: the model's reading, the fit and the diagnosis, against SciPy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.linalg import expm

from ident.campaign import read_campaign
from ident.campaign.record import MEASURES
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.ranking.confirm import confirm
from ident.diagnosis.ranking.score import score
from ident.effects.registry import built_in
from ident.errors import UserError
from ident.fit import fit
from ident.fit.linear.start_model import start_model
from ident.model import Model

F0, Q, GAIN, K3, OFFSET = 12.0, 25.0, 40.0, 3e5, 0.3
STEP, N = 1 / 600, 3000
NOISE = 1e-3  # of the signal
Sensor = Callable[[np.ndarray], np.ndarray]


def motion(seed: int, hardening: float) -> tuple[np.ndarray, ...]:
    """Time, drive, and displacement, velocity, acceleration of a Duffing oscillator that is already moving."""
    rng = np.random.default_rng(seed)
    tones = rng.uniform(0.4 * F0, 1.5 * F0, 12)
    phases = rng.uniform(0, 2 * np.pi, 12)
    drive = lambda t: np.sum(np.sin(2 * np.pi * tones * t + phases)) / 3
    w0 = 2 * np.pi * F0
    force = lambda t, y: GAIN * drive(t) - w0 / Q * y[1] - w0**2 * y[0] - hardening * y[0] ** 3
    t = STEP * np.arange(N)
    solved = solve_ivp(lambda t, y: (y[1], force(t, y)), (0, t[-1]), (1e-3, 0.1), "DOP853", t, rtol=1e-10, atol=1e-13)
    u = np.array([drive(x) for x in t])
    a = np.array([force(x, y) for x, y in zip(t, solved.y.T, strict=True)])
    return t, u, solved.y[0], solved.y[1], a


def campaign(
    folder: Path, measures: str, hardening: float = 0.0, offset: float = 0.0, sensor: Sensor = lambda read: read
) -> Path:
    """A folder with two records, one held out, that measure such a thing; `sensor`: what it makes of the reading."""
    order = MEASURES.index(measures)  # type: ignore[arg-type]
    unit = ("m", "m/s", "m/s^2")[order]
    text = 'device = { kind = "oscillator", output = "m" }\n'
    for seed, holdout in ((1, "false"), (2, "true")):
        t, u, *states = motion(seed, hardening)
        size = float(np.std(states[order]))
        zero = offset * GAIN * (2 * np.pi * F0) ** (order - 2)
        read = sensor(states[order]) + zero + NOISE * size * np.random.default_rng(seed).normal(size=N)
        table, header = np.stack([t, u, read], 1), f"time (s),drive (V),response ({unit})"
        np.savetxt(folder / f"{seed}.csv", table, "%.9g", ",", header=header, comments="")
        text += f'[[record]]\nfile = "{seed}.csv"\nholdout = {holdout}\nmeasures = "{measures}"\n'
    (folder / "campaign.toml").write_text(text)
    return folder


@pytest.mark.parametrize("measures", MEASURES)
def test_the_device_is_found_whatever_derivative_was_measured(tmp_path: Path, measures: str) -> None:
    read = read_campaign(campaign(tmp_path, measures, offset=OFFSET))
    found = fit(start_model(read), read)
    assert found.model.form == "oscillator" and found.model.names == ("sensor-offset",)
    assert np.isclose(found["frequency"].value, F0, rtol=1e-4)
    assert np.isclose(found["quality"].value, Q, rtol=1e-2)
    assert np.isclose(found["gain"].value, GAIN, rtol=2e-3)
    assert found.holdout is not None
    assert found.fitted.error_over_noise < 1.1 and found.holdout.error_over_signal < 1.5 * NOISE


@pytest.mark.parametrize("measures", MEASURES[1:])
def test_the_missing_effect_is_the_one_of_the_displacement(tmp_path: Path, measures: str) -> None:
    read = read_campaign(campaign(tmp_path, measures, hardening=K3))
    found = fit(start_model(read), read)
    assert found.fitted.error_over_noise > 3
    candidates = score(prepare(found), built_in())
    assert candidates[0].name == "cubic-stiffness"
    assert np.isclose(candidates[0].values["k3"], K3, rtol=0.2)


@pytest.mark.parametrize("order", [1, 2])
def test_a_reading_under_a_drive_that_jumps_is_right_where_it_jumps(order: int) -> None:
    """An oscillator under a pseudo-random switch, from the matrix exponential: no sample, at a jump or not, is off."""
    w0, rng = 2 * np.pi * F0, np.random.default_rng(3)
    drive = np.repeat(rng.choice([-1.0, 1.0], 150), 8)
    whole = expm(np.array([[0, 1, 0], [-(w0**2), -w0 / Q, GAIN], [0, 0, 0]]) * STEP)
    state = np.zeros((len(drive), 2))
    for k in range(len(drive) - 1):
        state[k + 1] = whole[:2] @ [*state[k], drive[k]]
    exact = (state[:, 1], GAIN * drive - w0 / Q * state[:, 1] - w0**2 * state[:, 0])[order - 1]
    noise, unit = NOISE * float(np.std(exact)), ("m/s", "m/s^2")[order - 1]
    table = {"time": STEP * np.arange(len(drive)), "drive (V)": drive, f"response ({unit})": exact}
    told = {"data": table, "measures": MEASURES[order], "between": "hold", "noise": f"{noise} {unit}"}
    read = read_campaign({"device": {"kind": "oscillator", "output": "m"}, "record": [told]})
    found = fit(Model(read.device), read)
    left = (exact - found.readings[0]) / noise
    assert np.max(np.abs(left)) < 0.2, "at a jump or not"


CORNER, LATE = 4.0, 1 / F0 / 12  # 1/s, s


def high_pass(read: np.ndarray) -> np.ndarray:
    """A capacitor at the input, switched on with the record: reading = x − r q, q̇ = x − r q."""
    x = CubicSpline(STEP * np.arange(N), read)
    rate = lambda t, q: x(t) - CORNER * q
    solved = solve_ivp(rate, (0, STEP * (N - 1)), [0.0], "DOP853", STEP * np.arange(N), rtol=1e-9, atol=1e-12)
    return read - CORNER * solved.y[0]


def low_pass(read: np.ndarray) -> np.ndarray:
    """A filter of the first order, at zero when the record begins."""
    x = CubicSpline(STEP * np.arange(N), read)
    rate = lambda t, q: (x(t) - q) / LATE
    return solve_ivp(rate, (0, STEP * (N - 1)), [0.0], "DOP853", STEP * np.arange(N), rtol=1e-9, atol=1e-12).y[0]


def saturating(read: np.ndarray) -> np.ndarray:
    """To the arctangent, by a tenth at three standard deviations of the first record."""
    size = 5.0 * min((np.std(x) for x in motion(1, 0.0)[2:]), key=lambda x: abs(np.log(x / np.std(read))))
    return size * np.arctan(read / size)


@pytest.mark.parametrize("measures", MEASURES)
@pytest.mark.parametrize(
    ("sensor", "name", "parameter", "unit"),
    [
        (high_pass, "ac-coupling", "corner", "1/s"),
        (low_pass, "sensor-lag", "time", "s"),
        (saturating, "sensor-nonlinearity", "cubic", "1/m^2"),
    ],
)
def test_a_sensor_acts_on_what_it_reads(
    tmp_path: Path, measures: str, sensor: Sensor, name: str, parameter: str, unit: str
) -> None:
    read = read_campaign(campaign(tmp_path, measures, sensor=sensor))
    found = fit(Model(read.device), read)
    regression = prepare(found)
    candidate = next(c for c in score(regression, built_in()) if c.name == name)
    confirmed = confirm(regression, built_in()[name], candidate)
    best = fit(confirmed.model, read, initial=confirmed.values)
    assert best.holdout is not None
    assert best.fitted.error_over_noise < 1.1 and best.holdout.error_over_noise < 1.2
    told, order = best[f"{name}.{parameter}"], read.order
    seen = motion(1, 0.0)[2 + order]
    true = {"corner": CORNER, "time": LATE, "cubic": 1 / 3 / (5.0 * float(np.std(seen))) ** 2}[parameter]
    assert np.isclose(told.value, true, rtol=0.02 if parameter != "cubic" else 0.2)
    assert told.unit == (unit if parameter != "cubic" or not order else f"1/m^2*s^{2 * order}")


def test_a_fit_that_is_told_of_an_ac_coupling_finds_its_corner(tmp_path: Path) -> None:
    read = read_campaign(campaign(tmp_path, "acceleration", sensor=high_pass))
    found = fit(Model(read.device) + built_in()["ac-coupling"](), read)
    assert np.isclose(found.value("ac-coupling.corner"), CORNER, rtol=0.02)
    assert found.fitted.error_over_noise < 1.1


def test_a_unit_of_acceleration_says_that_it_is_one(tmp_path: Path) -> None:
    folder = campaign(tmp_path, "acceleration")
    alone = read_campaign(folder / "1.csv")
    assert alone.traces[0].measures == "acceleration" and alone.device.output == "m"  # type: ignore[union-attr]
    assert any('measures = "acceleration"' in note for note in alone.notes)
    toml = folder / "campaign.toml"
    toml.write_text(toml.read_text().replace('measures = "acceleration"\n', ""))
    with pytest.raises(UserError, match="not a unit of response") as caught:
        read_campaign(folder)
    assert 'measures = "acceleration"' in caught.value.do
    toml.write_text(toml.read_text().replace('output = "m"', 'output = "m/s^2"'))
    assert read_campaign(folder).traces[0].measures == "acceleration"


@pytest.mark.parametrize(
    ("measures", "ratio"), [("displacement", 1.25), ("acceleration", 1.25), ("acceleration", 0.45)]
)
def test_a_second_mode_close_by_is_a_second_mode(tmp_path: Path, measures: str, ratio: float) -> None:
    order, share = MEASURES.index(measures), 0.3  # type: ignore[arg-type]
    t, u, *first = motion(4, 0.0)
    w2 = 2 * np.pi * F0 * ratio
    drive = CubicSpline(t, u)
    rate = lambda t, y: (y[1], GAIN * drive(t) - w2 / Q * y[1] - w2**2 * y[0])
    second = solve_ivp(rate, (0, t[-1]), (0.0, 0.0), "DOP853", t, rtol=1e-9, atol=1e-13).y
    other = (second[0], second[1], GAIN * u - w2 / Q * second[1] - w2**2 * second[0])[order]
    read = first[order] + share * other
    read += 3 * NOISE * np.std(read) * np.random.default_rng(0).normal(size=N)
    header = f"time (s),drive (V),response ({('m', 'm/s', 'm/s^2')[order]})"
    np.savetxt(tmp_path / "a.csv", np.stack([t, u, read], 1), "%.9g", ",", header=header, comments="")
    device = 'device = { kind = "oscillator", output = "m" }'
    (tmp_path / "campaign.toml").write_text(f'{device}\n[[record]]\nfile = "a.csv"\nmeasures = "{measures}"\n')
    campaign = read_campaign(tmp_path)
    start = fit(start_model(campaign), campaign)  # as linear as the device
    assert start.model.names == ("second-mode",) and start.fitted.error_over_noise < 1.1
    assert np.isclose(start.value("second-mode.period") * F0 * ratio, 1.0, rtol=0.01)
    campaign = replace(campaign, modes=1)
    found = prepare(fit(start_model(campaign), campaign))
    best = score(found, built_in())[0]
    assert best.name == "second-mode" and best.drop > 0.9 * found.chi2
    assert np.isclose(best.values["period"] * F0 * ratio, 1.0, rtol=0.1)
