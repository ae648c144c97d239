"""The response against SciPy, and the symmetry by which the zero-point offset separates the two mechanisms."""

import numpy as np
from scipy.integrate import solve_ivp

from ident.campaign.device import Oscillator, Platform
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.effects.registry import built_in
from ident.fit.reading import read
from ident.model import Model


def sine(hertz: float, volts: float, periods: int, per_period: int = 64, **more) -> Trace:
    t = np.arange(periods * per_period + 1) / (per_period * hertz)
    drive = volts * np.sin(2 * np.pi * hertz * t)
    channel = Channel("V", 1.0)
    told = {"noise": NoiseFloor(1e-3), "start": "rest"} | more
    return Trace("sine.csv", t, drive, np.zeros_like(t), channel, channel, **told)


def test_a_duffing_oscillator_agrees_with_scipy():
    record = sine(1.3, 2.0, 12, noise=NoiseFloor(1e-9))
    model = Model(Oscillator(), (built_in()["cubic-stiffness"](),))
    found = read(model, np.array([1.0, 12.0, 5.0, 40.0, 0.0]), [record])[0]
    omega = 2 * np.pi

    def rates(t, y):
        force = 5.0 * 2.0 * np.sin(2 * np.pi * 1.3 * t)
        return y[1], force - omega / 12.0 * y[1] - omega**2 * y[0] - 40.0 * y[0] ** 3

    exact = solve_ivp(rates, (0, record.time[-1]), [0, 0], t_eval=record.time, method="DOP853", rtol=1e-11, atol=1e-13)
    assert np.max(np.abs(found - exact.y[0])) < 1e-5 * np.max(np.abs(exact.y[0]))


STRESS = {"sigma12": 80e6, "sigma23": 45e6, "restraint": 0.5}


def harmonics(effects: tuple) -> np.ndarray:
    """Mean, fundamental and second harmonic of the last whole periods, m, when all has settled."""
    record = sine(317.0, 8.0, 160, noise=NoiseFloor(1e-9))
    model = Model(Platform(), effects)
    given = {f"{e.name}.{name}": value for e in effects for name, value in e.values.items()}
    values = np.array([given.get(p.name, 0.0) for p in model.parameters])
    values[:3] = 500.0, 20.0, 64e-12
    last = read(model, values, [record])[0][-64 * 8 - 1 : -1]
    spectrum = np.fft.rfft(last) / len(last)
    return np.abs(spectrum[[0, 8, 16]]) * np.array([1.0, 2.0, 2.0])


def test_hysteresis_alone_gives_no_offset_and_residual_stress_does():
    library = built_in()
    hysteresis = library["pzt-hysteresis"](eta=2e-23, zeta=2e-23)
    stress = library["residual-stress"](**STRESS)
    mean, first, second = harmonics((hysteresis,))
    assert max(mean, second) < 1e-6 * first
    mean, first, second = harmonics((stress, hysteresis))
    assert mean > 1e-4 * first
    assert second > 1e-4 * first


def test_records_of_any_length_come_back_in_their_own():
    records = [sine(400.0, 1.0, n) for n in (3, 20, 5, 19)]
    found = read(Model(Oscillator()), np.array([500.0, 20.0, 1.0]), records)
    assert [len(r) for r in found] == [len(r.time) for r in records]
    alone = read(Model(Oscillator()), np.array([500.0, 20.0, 1.0]), records[1:2])[0]
    np.testing.assert_allclose(found[1], alone, rtol=1e-9, atol=1e-20)
