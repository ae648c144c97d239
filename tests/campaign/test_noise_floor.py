"""The noise floor is found without the model, within 10 % of the truth, whatever the drive, start and colour."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from experiments.hidden_noise import pink
from ident.campaign.noise.autoregression import fit_autoregression, levinson, variance_of
from ident.campaign.noise.floor import noise_floor
from ident.campaign.noise.hum import HUMS
from ident.campaign.noise.of_others import beside_others
from ident.campaign.noise.one_sensor import of_one_sensor
from ident.campaign.noise.pool import pooled
from ident.campaign.period import find_period
from ident.campaign.read import read_campaign
from ident.campaign.record import NoiseFloor
from tests.campaign.records import coloured, multisine, respond, sine

WHITE: tuple[float, ...] = ()
SINES = [
    (317, 90, 0.0),
    (505, 60, 0.0),
    (200, 100, 0.0),
    (480, 25, 0.0),
    (150, 33.3, 0.0),
    (317, 40, 0.4),
    (505, 61.7, 0.4),
]


@pytest.fixture(scope="module")
def clean():
    """Responses to a sine, one per (frequency, samples per period, lead); lead 0 starts from rest."""
    return {case: respond(sine(case[0]), 2000, case[0] * case[1], lead=case[2]) for case in SINES}


def _floor(record, noise) -> NoiseFloor:
    time, drive, response = record
    return noise_floor(time, drive, response + noise, find_period(drive))


@pytest.mark.parametrize("case", SINES, ids=str)
@pytest.mark.parametrize("level", [0.001, 0.01, 0.03])
def test_white_noise(clean, case, level):
    rng = np.random.default_rng(int(case[0]))
    sigma = level * np.std(clean[case][2])
    floor = _floor(clean[case], coloured(rng, 2000, WHITE, sigma))
    assert floor.ar == ()
    assert floor.sigma == pytest.approx(sigma, rel=0.10)
    assert floor.relative_error < 0.05 and floor.method


@pytest.mark.parametrize(("ar", "allowed"), [((0.5,), 0.10), ((0.9,), 0.20), ((1.2, -0.5), 0.12)], ids=str)
def test_coloured_noise(clean, ar, allowed):
    rng = np.random.default_rng(5)
    ratios, orders = [], []
    for record in clean.values():
        sigma = 0.005 * np.std(record[2])
        floor = _floor(record, coloured(rng, 2000, ar, sigma))
        ratios.append(floor.sigma / sigma)
        orders.append(len(floor.ar))
    assert np.median(ratios) == pytest.approx(1.0, abs=0.06)
    assert np.max(np.abs(np.array(ratios) - 1)) < allowed
    assert orders.count(len(ar)) >= len(orders) - 1


@pytest.mark.parametrize("ar", [(0.5,), (0.9,), (0.95,)], ids=str)
def test_records_of_one_sensor_share_the_colour(clean, ar):
    rng = np.random.default_rng(8)
    sigmas = [0.01 * float(np.std(record[2])) for record in clean.values()]
    pairs = zip(clean.values(), sigmas, strict=True)
    floors = [_floor(record, coloured(rng, 2000, ar, sigma)) for record, sigma in pairs]
    shared = pooled(floors, [2000] * len(floors))
    assert len({floor.ar for floor in shared}) == 1
    ratios = np.array([floor.sigma / sigma for floor, sigma in zip(shared, sigmas, strict=True)])
    assert np.max(np.abs(ratios - 1)) < 0.10


def test_different_colours_are_not_shared():
    floors = [NoiseFloor(1.0, (0.5,), "a", 0.02), NoiseFloor(1.0, (0.95,), "b", 0.05)]
    assert pooled(floors, [2000, 2000]) == floors


@pytest.mark.parametrize("slow", [0.8, 0.95])
def test_what_a_drive_hides_of_a_red_noise_is_told_by_a_periodic_record(clean, slow):
    """White noise and a red one beside it: under a chirp the floor had been a third too low or high."""
    rng = np.random.default_rng(17)

    def red(n: int, sigma: float) -> np.ndarray:
        return (0.6 * rng.standard_normal(n) + 0.8 * coloured(rng, n, (slow,), 1.0)) * sigma

    rate, n = SINES[0][0] * SINES[0][1], 4000
    sweep = lambda t: np.sin(2 * np.pi * (300 + 1000 * np.asarray(t)) * np.asarray(t))
    records, sigmas = [clean[SINES[0]], respond(sweep, n, rate), respond(sweep, n, rate, quality=15.0)], []
    traces = []
    for time, drive, response in records:
        noise = red(len(response), 0.006 * float(np.std(response)))
        sigmas.append(float(np.std(noise)))
        read = response + noise
        floor = noise_floor(time, drive, read, find_period(drive))
        traces.append(SimpleNamespace(noise=floor, response=read, masked=None, step=1 / rate, measures="displacement"))
    own, told = [trace.noise for trace in traces], of_one_sensor(traces)
    assert told[0] is own[0] and own[0].relative_error < 0.1 <= min(floor.relative_error for floor in own[1:])
    for floor, sigma in zip(told, sigmas, strict=True):
        assert floor.sigma == pytest.approx(sigma, rel=0.08) and floor.relative_error < 0.1
    other = SimpleNamespace(**vars(traces[1]) | {"step": 0.7 / rate})  # sampled otherwise
    assert of_one_sensor([traces[0], other])[1] is other.noise
    time, drive, response = records[1]
    read = response + 0.006 * rng.standard_normal(n)  # another sensor
    other = SimpleNamespace(
        noise=noise_floor(time, drive, read, None), response=read, masked=None, step=1 / rate, measures="displacement"
    )
    assert of_one_sensor([traces[0], other])[1] is other.noise


def test_pink_noise_is_told_from_one_that_levels_off():
    """Of records of one sensor, each beneath a sweep: extrapolated by two coefficients the floors were 0.5 to 0.7 of
    the noise. One that levels off, and a white one, stay what they are."""
    rng, n = np.random.default_rng(23), 5000
    sweep = lambda t: np.sin(2 * np.pi * (300 + 1000 * np.asarray(t)) * np.asarray(t))
    time, drive, response = respond(sweep, n, SINES[0][0] * SINES[0][1])
    size = 0.005 * float(np.std(response))

    def told(noise) -> tuple[float, list[float]]:
        """Floors over noise, those of one record alone and of all together."""
        traces = []
        for one in range(5):
            read = response + size * noise(one)
            floor = noise_floor(time, drive, read, find_period(drive))
            traces.append(
                SimpleNamespace(noise=floor, response=read, masked=None, step=time[1], measures="displacement")
            )
        together = [floor.sigma / size for floor in of_one_sensor(traces)]
        return float(np.median([t.noise.sigma / size for t in traces])), together

    alone, together = told(lambda _: np.hypot(0.95, 0.3) ** -1 * (0.95 * pink(rng, n) + 0.3 * rng.standard_normal(n)))
    assert 0.8 < alone < 1.2
    assert all(0.85 < one < 1.2 for one in together)
    alone, together = told(lambda _: coloured(rng, n, (0.6,), 1.0))
    assert 0.85 < alone < 1.15 and all(0.85 < one < 1.15 for one in together)
    alone, together = told(lambda _: rng.standard_normal(n))
    assert 0.9 < alone < 1.1 and all(0.9 < one < 1.1 for one in together)  # as it claims


def _beside_others(*floors: NoiseFloor) -> list[NoiseFloor]:
    traces = [SimpleNamespace(noise=floor, masked=None, step=1e-4, measures="displacement") for floor in floors]
    return beside_others(traces, floors)


def test_a_floor_that_no_frequency_shows_is_weighed_with_the_others_of_its_sensor():
    """Beneath a broadband drive red noise was taken for white: the right model stood at 1.7 of its noise floors."""
    vague, sure = NoiseFloor(4.7, (), "just above", 0.5), [NoiseFloor(s, (0.5,), "a", 0.05) for s in (7.9, 8, 8.1, 8)]
    told = _beside_others(*sure, vague)
    assert told[:4] == sure
    assert told[4].sigma == pytest.approx(8.0, rel=0.03) and told[4].ar == (0.5,)
    assert 0.04 < told[4].relative_error < 0.1


def test_others_that_disagree_tell_little():
    vague, others = NoiseFloor(4.7, (), "just above", 0.5), [NoiseFloor(s, (), "a", 0.05) for s in (2, 4, 16, 32.0)]
    told = _beside_others(*others, vague)[4]
    assert told.sigma == pytest.approx(4.7, rel=0.2) and told.relative_error > 0.4


@pytest.mark.parametrize(
    "own",
    [
        NoiseFloor(100.0, (), "the resolution", 0.5),  # a coarser range, whose steps are its floor
        NoiseFloor(0.1, (), "just above", 0.5),
        NoiseFloor(4.7, (0.9,), "extrapolated from the highest frequencies", 0.5, 0.4),  # it has its own colour
    ],
    ids=["far above", "far below", "seen"],
)
def test_a_floor_of_another_kind_stays(own):
    sure = [NoiseFloor(s, (0.5,), "a", 0.05) for s in (7.9, 8, 8.1, 8)]
    assert _beside_others(*sure, own)[4] is own
    assert _beside_others(*sure[:3], NoiseFloor(4.7, (), "just above", 0.5))[3].sigma == 4.7  # three are too few


def test_mains_hum_is_noise():
    rng = np.random.default_rng(2)
    time, drive, response = respond(sine(317), 2000, 317 * 25, lead=0.4)
    noise = coloured(rng, 2000, WHITE, 0.01) + 0.01 * np.sqrt(2) * np.sin(2 * np.pi * 50 * time)
    floor = _floor((time, drive, response), noise)
    assert floor.sigma == pytest.approx(0.01 * np.sqrt(2), rel=0.15)
    assert "hum" in floor.method and floor.lines == (HUMS,) and floor.ar


@pytest.mark.parametrize(("ar", "samples"), [((), 2000), ((0.5,), 2000), ((0.9,), 2000), ((), 6000)], ids=str)
def test_repeats_of_a_multisine(ar, samples):
    rng = np.random.default_rng(4)
    drive = multisine(0.05, range(1, 30), rng)
    record = respond(drive, samples, 10_000, lead=0.3)
    assert find_period(record[1]) == pytest.approx(500)
    floor = _floor(record, coloured(rng, samples, ar, 0.01))
    assert floor.sigma == pytest.approx(0.01, rel=0.12)
    assert "repeats" in floor.method and len(floor.ar) == len(ar)


def test_a_swept_sine_leaves_the_high_frequencies():
    rng = np.random.default_rng(6)
    record = respond(
        lambda t: np.sin(2 * np.pi * (100 * np.asarray(t) + 0.5 * 500 / 0.2 * np.asarray(t) ** 2)), 2000, 1e4
    )
    floor = _floor(record, coloured(rng, 2000, WHITE, 0.02))
    assert floor.sigma == pytest.approx(0.02, rel=0.25)
    assert floor.relative_error >= 0.1 and "frequencies" in floor.method


def test_a_band_without_free_frequencies_says_so():
    rng = np.random.default_rng(7)
    drive = lfilter_noise(rng, 6000)
    floor = noise_floor(np.arange(6000.0), drive, drive + 0.01 * rng.standard_normal(6000), None)
    assert floor.relative_error >= 0.5 and "taken as white" in floor.method


def lfilter_noise(rng, n):
    """Noise in the lower 70 % of the frequencies, and none above."""
    spectrum = np.fft.rfft(rng.standard_normal(n))
    spectrum[int(0.35 * n) :] = 0
    return np.fft.irfft(spectrum, n)


def test_a_free_decay_has_a_noise_floor():
    rng = np.random.default_rng(9)
    time = np.arange(2000) / 2e4
    decay = np.exp(-40 * time) * np.cos(2 * np.pi * 480 * time)
    floor = noise_floor(time, np.zeros(2000), decay + 0.003 * rng.standard_normal(2000), None)
    assert floor.sigma == pytest.approx(0.003, rel=0.1)


def test_a_noiseless_record_has_a_floor_above_zero(clean):
    record = clean[SINES[0]]
    assert 0 < noise_floor(*record, find_period(record[1])).sigma < 1e-3


def test_levinson_solves_yule_walker():
    ar = np.array([0.7, -0.3, 0.1])
    impulse = np.zeros(4000)
    impulse[0] = 1.0
    for k in range(1, 4000):
        impulse[k] = sum(ar[j] * impulse[k - 1 - j] for j in range(min(3, k)))
    covariance = np.array([np.sum(impulse[: 4000 - lag] * impulse[lag:]) for lag in range(4)])
    found, innovation = levinson(covariance, 3)
    np.testing.assert_allclose(found, ar, atol=1e-9)
    assert innovation == pytest.approx(1.0)
    assert variance_of(ar, 1.0) == pytest.approx(covariance[0])


def test_missing_frequencies_do_not_bias_the_colour():
    rng = np.random.default_rng(10)
    ratios = []
    for _ in range(8):
        noise = coloured(rng, 2000, (0.8,), 1.0)
        holes = np.zeros(1001, dtype=bool)
        holes[20::37] = holes[21::37] = True
        spectrum = np.fft.rfft(noise)
        spectrum[holes] += 300.0
        ratios.append(fit_autoregression(np.fft.irfft(spectrum, 2000), None, 6, holes).sigma)
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.05)


def test_a_transient_that_lasts_into_the_middle_of_a_strong_nonlinear_record_is_no_noise():
    sine_75 = next(r for r in read_campaign(Path("data/oscillator")).traces if r.name.startswith("sine"))
    assert sine_75.noise.sigma == pytest.approx(0.3e-3, rel=0.1)


@pytest.mark.parametrize(
    ("seed", "hidden", "starts", "size", "noise", "length"),
    [
        (2018, ("bouc-wen-drive",), "rest", 0.02, 0.003, 792),
        (2123, ("quadratic-stiffness",), "mixed", 0.08, 0.001, 1102),
        (2156, (), "mixed", 0.02, 0.01, 627),
    ],
)
def test_a_motion_beyond_description_hides_no_floor(seed, hidden, starts, size, noise, length):
    """Few periods near a sharp resonance leave up to 89 times the noise; what is far above the drive tells it."""
    case = draw(seed, hidden, size=size, noise=noise, records=4, length=length, starts=starts, device="oscillator")
    for record, truth in zip(campaign_of(case).traces, case.records, strict=True):
        assert record.noise.sigma < 1.3 * truth.sigma


def test_what_drifts_under_a_long_period_is_no_noise():
    """A stage without a spring never repeats: what two periods differ by is its motion, and it was called a floor 11 to
    32 times too high, once larger than the signal. The frequencies above those of the drive know better."""
    rng, rate, period = np.random.default_rng(3), 500.0, 2000
    t = np.arange(2 * period) / rate
    lines = np.arange(2, 48) * rate / period
    drive = sum(np.cos(2 * np.pi * f * t + rng.uniform(0, 2 * np.pi)) for f in lines)
    speed = np.cumsum(drive) / rate
    z = np.cumsum(speed - speed[0] + 3.0 * np.exp(-t / 2.0)) / rate
    sigma = 0.004 * float(np.std(z))
    found = noise_floor(t, np.asarray(drive), z + sigma * rng.normal(size=t.size), float(period))
    assert 0.9 < found.sigma / sigma < 1.1
    assert found.relative_error < 0.2
