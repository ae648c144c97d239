"""A noise floor that is only a bound falls to what the model leaves, and one that does not know of hum rises."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import butter, lfilter

import ident
from ident.campaign.noise.floor import extrapolated
from ident.campaign.record import VAGUE
from ident.fit.floors import _lowered, sharpened

STEP, SIGMA = 1 / 2048, 0.05


def _shaken(seed: int) -> dict[str, np.ndarray]:
    """White noise up to the last frequency on a structure of 34 Hz, its acceleration read with white noise."""
    time, rng = np.arange(2048) * STEP, np.random.default_rng(seed)
    drive = 4 * rng.normal(size=len(time))
    push, w = lambda t: np.interp(t, time, drive) / 3.2, 2 * np.pi * 34.0
    law = lambda t, y: [y[1], push(t) - w * w * y[0] - w / 45 * y[1]]
    z, v = solve_ivp(law, (0, time[-1]), [0, 0], t_eval=time, rtol=1e-8, atol=1e-10, max_step=STEP).y
    acceleration = push(time) - w * w * z - w / 45 * v
    return {"time": time, "drive": drive, "response": acceleration + rng.normal(0, SIGMA, len(time))}


def _campaign(**told: object) -> dict[str, object]:
    device = {"kind": "oscillator", "output": "m/s^2", "input": "N"}
    return {"device": device, "record": [{"data": _shaken(k), "start": "rest", **told} for k in (1, 2)]}


def test_a_floor_beside_a_broadband_drive_falls_to_the_noise():
    campaign = ident.read_campaign(_campaign())
    assert all(r.noise.relative_error >= VAGUE and r.noise.sigma > 2 * SIGMA for r in campaign.traces)
    found = ident.fit(campaign)
    assert [r.noise.sigma for r in found.campaign.traces] == pytest.approx([SIGMA, SIGMA], rel=0.1)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.1)
    assert all("what the model leaves" in r.noise.method for r in found.campaign.traces)


def test_noise_that_sweeps_hide_is_told_by_what_a_complete_model_leaves_beside_them():
    """White noise and a slow red one: extrapolated from above the sweeps, the floors are a fifth too low, and a model
    that lacked nothing "does not describe the records"."""
    rng, step, n, w = np.random.default_rng(5), 1 / 6000, 6000, 2 * np.pi * 146.0
    time, records, sigmas = step * np.arange(n), [], []
    for first, last in ((90.0, 210.0), (200.0, 100.0)):
        drive = np.sin(2 * np.pi * (first + (last - first) / 2 * time / time[-1]) * time)
        held = lambda t, u=drive: np.interp(t, time, u)
        law = lambda t, y, u=held: [y[1], w * w * (u(t) - y[0]) - w / 40 * y[1]]
        z, _ = solve_ivp(law, (0, time[-1]), [0, 0], t_eval=time, rtol=1e-8, atol=1e-10, max_step=step).y
        red = lfilter([np.sqrt(1 - 0.97**2)], [1.0, -0.97], rng.normal(size=n + 500))[500:]
        noise = 0.05 * (0.6 * rng.normal(size=n) + 0.8 * red)
        sigmas.append(float(np.std(noise)))
        records.append({"data": {"time": time, "drive": drive, "response": z + noise}, "start": "rest"})
    found = ident.fit({"device": {"kind": "oscillator"}, "record": records}, effects=())
    assert all(r.noise.sigma < 0.9 * s for r, s in zip(found.campaign.traces, sigmas, strict=True))
    again = sharpened(found)
    assert again is not None
    # Of 6000 samples of so slow a noise 200 are independent, by which its level is known to a twentieth.
    assert [r.noise.sigma for r in again.traces] == pytest.approx(sigmas, rel=0.07)
    assert all(r.noise.relative_error < 0.1 for r in again.traces)


def test_a_floor_that_was_given_stays():
    found = ident.fit(_campaign(noise="0.2 m/s^2"))
    assert [r.noise.sigma for r in found.campaign.traces] == [0.2, 0.2]
    assert found.fitted.error_over_noise == pytest.approx(SIGMA / 0.2, rel=0.1)


_TONES = ((90.0,), (144.0,), (61.0, 118.0, 131.0, 149.0, 171.0, 203.0))


def _sines(hum: float, bend: float = 0.0, hertz: float = 50.0, drives: tuple = _TONES) -> dict[str, object]:
    """Sines below and at the resonance of 146 Hz, and a sum of sines, each with a line in its own phase."""
    time, rng, records = np.arange(1800) / 4400, np.random.default_rng(4), []
    w = 2 * np.pi * 146.0
    for tones in drives:
        phases = rng.uniform(0, 2 * np.pi, len(tones))
        push = lambda t, tones=tones, p=phases: sum(
            np.sin(2 * np.pi * f * t + a) for f, a in zip(tones, p, strict=True)
        )
        law = lambda t, y, push=push: [y[1], w * w * (push(t) - y[0] - bend * y[0] ** 3) - w / 40 * y[1]]
        z, _ = solve_ivp(law, (0, time[-1]), [0, 0], t_eval=time, rtol=1e-8, atol=1e-10, max_step=5e-4).y
        z = z + hum * np.sin(2 * np.pi * hertz * time + rng.uniform(0, 2 * np.pi)) + rng.normal(0, 0.01, len(time))
        records.append({"data": {"time": time, "drive": push(time), "response": z}, "start": "rest"})
    return {"device": {"kind": "oscillator"}, "record": records}


@pytest.mark.parametrize("bend", [0.0, 2e-4])
def test_hum_that_stands_out_of_what_the_model_leaves_is_noise(bend):
    found = ident.fit(_sines(0.2, bend), effects=() if bend == 0.0 else ("cubic-stiffness",))
    assert [r.noise.sigma for r in found.campaign.traces] == pytest.approx([0.2 / np.sqrt(2)] * 3, rel=0.02)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.02)
    assert any("Mains hum counts as noise" in note for note in found.campaign.notes)


def test_a_line_that_all_records_show_whatever_drives_them_is_noise():
    found = ident.fit(_sines(0.2, 2e-4, 1234.5), effects=("cubic-stiffness",))
    assert [r.noise.sigma for r in found.campaign.traces] == pytest.approx([0.2 / np.sqrt(2)] * 3, rel=0.04)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.02)
    assert any("A line of the surroundings counts as noise" in note for note in found.campaign.notes)


@pytest.mark.parametrize("drives", [((90.0, 131.0),) * 3, ((144.0,),) * 3, _TONES])
def test_what_a_drive_makes_in_a_bent_spring_is_no_line_of_the_surroundings(drives):
    found = ident.fit(_sines(0.0, 2e-3, drives=drives), effects=())
    assert found.fitted.error_over_noise > 3.0
    assert not any("surroundings" in r.noise.method for r in found.campaign.traces)


def test_without_hum_no_floor_rises():
    found = ident.fit(_sines(0.0, 2e-4))
    assert not any("hum" in r.noise.method for r in found.campaign.traces)


def test_a_floor_beside_a_motion_that_jumps_falls_to_the_noise_once_the_jumps_are_told():
    """Dry friction in an acceleration: at all frequencies, so that a floor which claims a tenth is several times too
    high."""
    rng, time = np.random.default_rng(4), np.arange(3500) * 1e-3
    drive = lfilter(*butter(4, 0.03), rng.normal(size=len(time)))
    friction = 0.76 * np.sign(lfilter(*butter(2, 0.02), rng.normal(size=len(time))))
    motion = lfilter(*butter(2, 0.02), drive) + friction
    data = {"time": time, "drive": drive, "response": motion + rng.normal(0, SIGMA, len(time))}
    (record,) = ident.read_campaign(data, device={"kind": "oscillator"}).traces
    record = replace(record, noise=replace(record.noise, relative_error=0.12))  # as a shaker's claimed
    assert extrapolated(record.noise) and record.noise.sigma > 2 * SIGMA
    assert SIGMA < _lowered(record, motion).noise.sigma < 1.5 * SIGMA
