"""Tables of curves as laboratories write them, and what is said of those that cannot be right."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ident.campaign import Oscillator, Platform, Sweep, read_campaign
from ident.campaign.propose import propose
from ident.errors import UserError
from tests.campaign.curves import both_ways, duffing, write_table

FREQUENCY = np.linspace(470.0, 560.0, 46)
LEVELS = (3.0, 6.0, 9.0)
F, LEVEL, UP, RESPONSE = both_ways(tuple(v / 9 for v in LEVELS), FREQUENCY, 0.15)
LEVEL = 9 * LEVEL
METRES = 10e-6 * RESPONSE
DEGREES = np.degrees(np.angle(RESPONSE))


def _read(folder: Path, record: str = "", file: str = "s.csv", device: str = "") -> tuple[Sweep, str]:
    (folder / "campaign.toml").write_text(f'{device}\n[[record]]\nfile = "{file}"\nkind = "sweep"\n{record}\n')
    campaign = read_campaign(folder)
    return campaign.sweeps[0], " ".join(campaign.notes)


def _is(sweep: Sweep, phase: bool = True) -> None:
    """The sweep holds what was measured."""
    found = sweep.amplitude * (np.exp(1j * sweep.phase) if sweep.phase is not None else 1.0)
    wanted = METRES if phase else np.abs(METRES)
    for array, truth in ((sweep.frequency, F), (sweep.level, LEVEL), (sweep.up, UP)):
        np.testing.assert_allclose(array, truth, rtol=1e-7)
    assert (sweep.phase is not None) == phase
    np.testing.assert_allclose(found, wanted, atol=2e-7 * np.max(np.abs(METRES)))


SIZE = np.abs(METRES)
RATIO = SIZE / LEVEL
TABLES = {
    "plain": ("freq_Hz,drive_V,amplitude_um,phase_deg", [F, LEVEL, 1e6 * SIZE, DEGREES], ""),
    "kilohertz and radians": ("f [kHz],U [mV],A [nm],phase [rad]",
                              [F / 1e3, 1e3 * LEVEL, 1e9 * SIZE, np.radians(DEGREES)], ""),
    "peak to peak": ("f (Hz),Drive (Vpp),z (um pp),phase (deg)", [F, 2 * LEVEL, 2e6 * SIZE, DEGREES], ""),
    "effective values": ("f (Hz),Drive (Vrms),R (um rms),Theta (deg)",
                         [F, LEVEL / np.sqrt(2), 1e6 * SIZE / np.sqrt(2), DEGREES], ""),
    "effective values by the name": ("f (Hz),Vrms (V),amplitude_rms (um),phase (deg)",
                                     [F, LEVEL / np.sqrt(2), 1e6 * SIZE / np.sqrt(2), DEGREES], ""),
    "effective values by the campaign": ("f (Hz),level,amplitude,phase (deg)",
                                         [F, LEVEL / np.sqrt(2), 1e6 * SIZE / np.sqrt(2), DEGREES],
                                         'units = { level = "Vrms", amplitude = "um rms" }'),
    "real and imaginary": ("f (Hz),level (V),Re (um),Im (um)", [F, LEVEL, 1e6 * METRES.real, 1e6 * METRES.imag], ""),
    "of an analyser": ("Frequency (Hz),Source (V),Trace 1: Real [um],Trace 1: Imag [um]",
                       [F, LEVEL, 1e6 * METRES.real, 1e6 * METRES.imag], ""),
    "X and Y of a lock-in": ("Frequency (Hz),level (V),X (um rms),Y (um rms)",
                             [F, LEVEL, *(1e6 / np.sqrt(2) * p for p in (METRES.real, METRES.imag))], ""),
    "a lock-in that shows all": ("Frequency (Hz),level (V),X (um),Y (um),R (um),Theta (deg)",
                                 [F, LEVEL, 1e6 * METRES.real, 1e6 * METRES.imag, 1e6 * SIZE, DEGREES], ""),
    "a lock-in that shows no angle": ("Frequency (Hz),level (V),X (um),Y (um),Demod R (um)",
                                      [F, LEVEL, 1e6 * METRES.real, 1e6 * METRES.imag, 1e6 * SIZE], ""),
    "parts by the campaign": ("f (Hz),level (V),a,b", [F, LEVEL, 1e6 * METRES.real, 1e6 * METRES.imag],
                              'columns = { real = "a", imaginary = "b" }\nunits = { amplitude = "um" }'),
    "response per drive": ("f (Hz),level (V),H (um/V),phase (deg)", [F, LEVEL, 1e6 * RATIO, DEGREES], ""),
    "effective response per drive from peak to peak": (
        "f (Hz),level (Vpp),magnitude (um rms/Vpp),phase (deg)",
        [F, 2 * LEVEL, 1e6 * RATIO / np.sqrt(2) / 2, DEGREES], ""),
    "decibels of a micrometre": ("f (Hz),level (V),Magnitude (dB um),phase (deg)",
                                 [F, LEVEL, 20 * np.log10(1e6 * SIZE), DEGREES], ""),
    "decibels of a ratio": ("f (Hz),level (V),Magnitude (dB re 1 um/V),phase (deg)",
                            [F, LEVEL, 20 * np.log10(1e6 * RATIO), DEGREES], ""),
    "decibels of nothing": ("f (Hz),level (V),Mag_dB,phase (deg)", [F, LEVEL, 20 * np.log10(RATIO), DEGREES], ""),
    "decibels of a volt, drive": ("f (Hz),level (dBV),A (um),phase (deg)",
                                  [F, 20 * np.log10(LEVEL / np.sqrt(2)), 1e6 * SIZE, DEGREES], ""),
    "phase lag": ("f (Hz),level (V),A (um),phase lag (deg)", [F, LEVEL, 1e6 * SIZE, -DEGREES], ""),
    "phase that rises": ("f (Hz),level (V),A (um),phase (deg)", [F, LEVEL, 1e6 * SIZE, -DEGREES], ""),
    "phase from 0 to 360": ("f (Hz),level (V),A (um),phase (deg)", [F, LEVEL, 1e6 * SIZE, DEGREES % 360], ""),
    "phase with turns that were not taken": (
        "f (Hz),level (V),A (um),phase (deg)",
        [F, LEVEL, 1e6 * SIZE, DEGREES + 360 * np.random.default_rng(2).integers(-1, 2, len(F))], ""),
    "phase counted on from turn to turn": (
        "f (Hz),level (V),A (um),phase (deg)", [F, LEVEL, 1e6 * SIZE, DEGREES - 720], ""),
    "degrees that nobody names": ("f (Hz),level (V),A (um),phase", [F, LEVEL, 1e6 * SIZE, DEGREES % 360], ""),
    "radians that nobody names": (
        "f (Hz),level (V),A (um),phase", [F, LEVEL, 1e6 * SIZE, np.radians(DEGREES) % (2 * np.pi)], ""),
    "phase lag in radians": (
        "f (Hz),level (V),A (um),phase lag (rad)", [F, LEVEL, 1e6 * SIZE, np.radians(-DEGREES)], ""),
    "direction in words": ("f (Hz),level (V),A (um),phase (deg),direction", [F, LEVEL, 1e6 * SIZE, DEGREES, UP], ""),
}  # fmt: skip


@pytest.mark.parametrize("name", TABLES)
def test_a_table_gives_the_same_curves(tmp_path, name):
    header, columns, record = TABLES[name]
    write_table(tmp_path / "s.csv", header, columns)
    _is(_read(tmp_path, record)[0])


def test_an_inverted_sensor_whose_phase_lies_about_half_a_turn(tmp_path):
    seen = -RESPONSE * np.exp(0.2j * np.random.default_rng(3).standard_normal(len(F)))
    wrapped = np.degrees(np.angle(seen))
    assert np.max(np.abs(np.diff(wrapped[:15]))) > 300  # the file shows +180 and −180 in turn
    write_table(tmp_path / "s.csv", "f (Hz),level (V),A (um),phase (deg)", [F, LEVEL, 1e6 * SIZE, wrapped])
    sweep, _ = _read(tmp_path)
    assert sweep.phase is not None
    for run in sweep.runs:
        assert np.max(np.abs(np.diff(sweep.phase[run.rows]))) < np.pi
    np.testing.assert_allclose(np.exp(1j * sweep.phase), seen / np.abs(seen), atol=1e-6)


def test_conventions_and_ratios_are_said(tmp_path):
    for name, words in (("effective values", "rms values"), ("peak to peak", "peak-to-peak values"),
                        ("response per drive", "multiplied by the drive level"), ("decibels of nothing", "1 m per V"),
                        ("real and imaginary", "complex"), ("phase that rises", "lag")):  # fmt: skip
        header, columns, record = TABLES[name]
        write_table(tmp_path / "s.csv", header, columns)
        assert words in _read(tmp_path, record)[1], name


def test_the_amplitude_alone(tmp_path):
    write_table(tmp_path / "s.csv", "f (Hz),level (V),A (um)", [F, LEVEL, 1e6 * SIZE])
    _is(_read(tmp_path)[0], phase=False)


def test_volts_of_an_oscillator_in_decibels(tmp_path):
    write_table(tmp_path / "s.csv", "f (Hz),Drive (Vrms),Gain (dB),phase (deg)",
                [F, LEVEL / np.sqrt(2), 20 * np.log10(1e5 * RATIO), DEGREES])  # fmt: skip
    campaign = read_campaign(tmp_path / "s.csv")
    assert "oscillator" in " ".join(campaign.notes)
    np.testing.assert_allclose(campaign.sweeps[0].amplitude, 1e5 * SIZE, rtol=1e-6)
    np.testing.assert_allclose(campaign.sweeps[0].level, LEVEL, rtol=1e-6)


def test_curves_side_by_side(tmp_path):
    f = FREQUENCY
    columns, names = [f], ["f (Hz)"]
    for level in LEVELS:
        for up in (True, False):
            here = (level == LEVEL) & (up == UP)
            columns.append(1e6 * SIZE[here][:: 1 if up else -1])
            names.append(f"{level:g} V {'up' if up else 'down'} (um)")
    write_table(tmp_path / "s.csv", ",".join(names), columns)
    sweep, notes = _read(tmp_path)
    assert "side by side" in notes and len(sweep.runs) == 6
    for run in sweep.runs:
        here = (run.level == LEVEL) & (run.up == UP)
        np.testing.assert_allclose(sweep.frequency[run.rows], F[here])
        np.testing.assert_allclose(sweep.amplitude[run.rows], SIZE[here], rtol=1e-7)


def test_one_file_per_level_tells_by_its_name(tmp_path):
    here = (LEVEL == 6.0) & UP
    write_table(tmp_path / "sweep_6V_up.csv", "f (Hz),A (um)", [F[here], 1e6 * SIZE[here]])
    campaign = read_campaign(tmp_path / "sweep_6V_up.csv")
    assert set(campaign.sweeps[0].level) == {6.0} and 'level = "6 V"' in " ".join(campaign.notes)
    write_table(tmp_path / "falling_2.5Vpp_down.csv", "f (Hz),A (um)", [F[here], 1e6 * SIZE[here]])
    sweep = read_campaign(tmp_path / "falling_2.5Vpp_down.csv").sweeps[0]
    assert set(sweep.level) == {1.25} and not sweep.up.any()  # sorted by the instrument, but swept down
    write_table(tmp_path / "s.csv", "f (Hz),A (um)", [F[here], 1e6 * SIZE[here]])
    assert set(_read(tmp_path, 'level = "12 Vpp"')[0].level) == {6.0}


def test_a_monitored_level_sags_at_resonance_and_stays_one_level(tmp_path):
    sag = LEVEL * (1 - 0.03 * np.abs(RESPONSE))
    write_table(tmp_path / "s.csv", "f (Hz),level (V),A (um)", [F, sag, 1e6 * SIZE])
    sweep, _ = _read(tmp_path)
    assert len(sweep.runs) == 6
    np.testing.assert_allclose(sweep.level, sag, rtol=1e-7)


def test_how_long_a_point_was_held(tmp_path):
    time = 0.25 * np.arange(len(F))
    write_table(tmp_path / "s.csv", "time (s),f (Hz),level (V),amplitude (um)", [time, F, LEVEL, 1e6 * SIZE])
    assert read_campaign(tmp_path / "s.csv").sweeps, "a table with times and amplitudes is a sweep all the same"
    assert np.allclose(_dwell(tmp_path), 0.25)
    write_table(tmp_path / "s.csv", "f (Hz),level (V),amplitude (um)", [F, LEVEL, 1e6 * SIZE])
    assert _read(tmp_path)[0].dwell is None
    assert np.allclose(_dwell(tmp_path, 'dwell = "200 ms"'), 0.2)
    assert np.allclose(_dwell(tmp_path, 'sweep_rate = "4 Hz/s"'), 0.5)


def _dwell(folder: Path, record: str = "") -> np.ndarray:
    found = _read(folder, record)[0].dwell
    assert found is not None
    return found


def test_noise_that_is_given(tmp_path):
    write_table(tmp_path / "s.csv", "f (Hz),level (V),amplitude (um)", [F, LEVEL, 1e6 * SIZE])
    sweep, _ = _read(tmp_path, 'noise = "12 nm + 0.5 %"')
    np.testing.assert_allclose(sweep.deviation, np.hypot(12e-9, 0.005 * SIZE), rtol=1e-6)
    sweep, _ = _read(tmp_path, 'noise = "2 %"')
    np.testing.assert_allclose(sweep.deviation, 0.02 * SIZE, rtol=1e-3)


def test_shuffled_rows_are_put_in_order_where_the_direction_is_known(tmp_path):
    order = np.random.default_rng(0).permutation(len(F))
    columns = [x[order] for x in (F, LEVEL, 1e6 * SIZE, UP.astype(float))]
    write_table(tmp_path / "s.csv", "f (Hz),level (V),amplitude (um),up", columns)
    sweep, _ = _read(tmp_path)
    for run in sweep.runs:
        steps = np.diff(sweep.frequency[run.rows])
        assert np.all(steps > 0) if run.up else np.all(steps < 0)
        here = (run.level == LEVEL) & (run.up == UP)
        np.testing.assert_allclose(sweep.amplitude[run.rows], SIZE[here], rtol=1e-7)


def test_repeated_frequencies(tmp_path):
    columns = [F, LEVEL, 1e6 * SIZE]
    twice = [np.insert(x, 7, x[6]) for x in columns]
    write_table(tmp_path / "s.csv", "f (Hz),level (V),amplitude (um)", twice)
    sweep, notes = _read(tmp_path)
    assert len(sweep.frequency) == len(F) and "1 row repeats another one" in notes
    twice[2][7] *= 1.01
    write_table(tmp_path / "s.csv", "f (Hz),level (V),amplitude (um)", twice)
    sweep, notes = _read(tmp_path)
    assert len(sweep.frequency) == len(F) + 1 and len(sweep.runs) == 6
    assert "count as repeats, which differ by up to" in notes
    assert np.isfinite(sweep.deviation).all() and (sweep.deviation > 0).all()


@pytest.mark.parametrize("cubic", [0.15, -0.1], ids=["hardening", "softening"])
@pytest.mark.parametrize("phase", [True, False], ids=["phase", "amplitude"])
def test_a_loop_that_runs_backwards_is_turned_and_said(tmp_path, cubic, phase):
    f, level, up, response = both_ways((0.4, 1.0), np.linspace(450.0, 560.0, 56), cubic)
    header, columns = "f (Hz),level (V),up,A (um)", [f, 9 * level, (~up).astype(float), 10 * np.abs(response)]
    if phase:
        header, columns = header + ",phase (deg)", [*columns, np.degrees(np.angle(response))]
    write_table(tmp_path / "s.csv", header, columns)
    sweep, notes = _read(tmp_path)
    np.testing.assert_array_equal(sweep.up, up)
    assert "up and down are exchanged" in notes
    columns[2] = up.astype(float)
    write_table(tmp_path / "s.csv", header, columns)
    sweep, notes = _read(tmp_path)
    np.testing.assert_array_equal(sweep.up, up)
    assert "exchanged" not in notes


def test_a_direction_against_the_rows_is_believed_and_said(tmp_path):
    f = FREQUENCY[::-1]
    write_table(tmp_path / "s.csv", "f (Hz),A (um)", [f, 10 * np.abs(duffing(0.3, f))])
    sweep, notes = _read(tmp_path, 'level = "3 V"\ndirection = "up"')
    assert sweep.up.all() and "frequencies fall from row to row" in notes


def _points(**changes: np.ndarray) -> dict[str, np.ndarray]:
    return {"f (Hz)": F, "level (V)": LEVEL, "amplitude (um)": 1e6 * SIZE} | changes


BROKEN = {
    "negative amplitudes": ({"amplitude (um)": 1e6 * METRES.imag}, "", ("s.csv, line", "negative", "real")),
    "decibels without saying so": ({"amplitude (um)": 20 * np.log10(1e6 * RATIO)}, "", ("negative", "dB")),
    "plain numbers called decibels": (
        {"amplitude (um)": 1e-6 * SIZE}, 'units = { amplitude = "dB um" }', ("dB", "plain numbers", "amplitude")),
    "a level of zero": ({"level (V)": LEVEL - 3.0}, "", ("s.csv, line 2", "drive level must be positive")),
    "amplitudes of zero": ({"amplitude (um)": 0 * F}, "", ("amplitudes are zero",)),
    "no number": ({"amplitude (um)": np.where(F[4] == F, np.nan, 1e6 * SIZE)}, "", ("s.csv, line 6", "finite")),
    "rows in no order": ({"f (Hz)": np.random.default_rng(1).permutation(F)}, "", ("direction", "up")),
    "a strange unit": ({}, 'units = { amplitude = "kg" }', ("campaign.toml", "kg")),
    "noise of more than all": ({}, 'noise = "150 %"', ("campaign.toml, line 5", "150 %")),
    "both dwell and rate": ({}, 'dwell = "1 s"\nsweep_rate = "1 Hz/s"', ("campaign.toml", "dwell")),
    "metres without saying micro": ({}, 'units = { amplitude = "m" }', ("cannot be right for a platform", "unit")),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_what_cannot_be_right_is_one_line_of_advice(tmp_path, name):
    changes, record, words = BROKEN[name]
    table = _points(**changes)
    write_table(tmp_path / "s.csv", ",".join(table), list(table.values()))
    with pytest.raises(UserError) as caught:
        _read(tmp_path, record)
    text = str(caught.value)
    assert all(word in text for word in words) and "\n" not in text, text


def test_no_level_anywhere(tmp_path):
    write_table(tmp_path / "s.csv", "f (Hz),A (um)", [F, 1e6 * SIZE])
    with pytest.raises(UserError, match='level = "3 V"'):
        _read(tmp_path)


def _pendulum(folder: Path) -> None:
    write_table(folder / "pendulum.csv", "f_Hz,torque_mNm,theta_deg,phase_deg",
                [F, LEVEL, np.degrees(0.1 * np.abs(RESPONSE)), DEGREES])  # fmt: skip


def _lock_in(folder: Path) -> None:
    write_table(folder / "paddle.csv", "frequency_Hz,drive_mVrms,response_mVrms,phase_deg,sweep",
                [F, 1e3 * LEVEL / np.sqrt(2), 1e8 * SIZE / np.sqrt(2), DEGREES, np.where(UP, 1, -1)])  # fmt: skip


def _millimetres(folder: Path) -> None:
    for name, own in (("up", UP), ("down", ~UP)):
        write_table(folder / f"beam_{name}.csv", "f [Hz],V_exc [V],X [mm],phi [deg]",
                    [F[own], LEVEL[own], 0.3e6 * SIZE[own], DEGREES[own]])  # fmt: skip


@pytest.mark.parametrize(
    ("write", "device", "level", "size"),
    [
        (_pendulum, ("rad", "Nm"), 1e-3, 0.1 * np.abs(RESPONSE)),
        (_lock_in, ("V", "V"), 1.0, 1e5 * SIZE),
        (_millimetres, ("m", "V"), 1.0, 0.3e3 * SIZE),
    ],
)
def test_a_campaign_for_curves_of_any_device_is_proposed(write, device, level, size, tmp_path: Path) -> None:
    write(tmp_path)
    paths = sorted(tmp_path.glob("*.csv"))
    (tmp_path / "campaign.toml").write_text(propose(paths, tmp_path), encoding="utf-8")
    campaign = read_campaign(tmp_path)
    assert isinstance(campaign.device, Oscillator)
    assert (campaign.device.output, campaign.device.input) == device
    held = {float(np.round(sweep.level[0] / level, 3)) for sweep in campaign.sweeps if sweep.holdout}
    assert held == {LEVELS[1]} and len(campaign.sweeps) == len(LEVELS) * len(paths)
    found = np.concatenate([np.stack([s.frequency, s.level, s.up, s.amplitude]) for s in campaign.sweeps], axis=1)
    true = np.stack([F, level * LEVEL, UP, size])
    in_order = lambda rows: rows[:, np.lexsort((rows[0], rows[2], np.round(rows[1] / level, 3)))]
    np.testing.assert_allclose(in_order(found), in_order(true), rtol=1e-5)
    assert all(sweep.phase is not None for sweep in campaign.sweeps)


def test_levels_of_a_force_in_the_names_of_files(tmp_path: Path) -> None:
    """Beside them the only column in volts is what was read."""
    for level in LEVELS:
        own = level == LEVEL
        write_table(tmp_path / f"beam {level:g} N.csv", "frequency (Hz),demod R (Vrms),phase (deg)",
                    [F[own], 1e5 * SIZE[own] / np.sqrt(2), DEGREES[own]])  # fmt: skip
    paths = sorted(tmp_path.glob("*.csv"))
    (tmp_path / "campaign.toml").write_text(propose(paths, tmp_path), encoding="utf-8")
    campaign = read_campaign(tmp_path)
    assert isinstance(campaign.device, Oscillator)
    assert (campaign.device.output, campaign.device.input) == ("V", "N")
    assert sorted(float(sweep.level[0]) for sweep in campaign.sweeps) == pytest.approx(sorted(LEVELS))
    assert max(np.max(sweep.amplitude) for sweep in campaign.sweeps) == pytest.approx(np.max(1e5 * SIZE), rel=1e-4)


def test_a_sweep_far_from_every_resonance_of_a_platform_is_another_device(tmp_path: Path) -> None:
    for factor, device in ((1.0, Platform), (0.2, Oscillator), (20.0, Oscillator)):
        write_table(tmp_path / "s.csv", "f (Hz),drive (V),amplitude (um)", [factor * F, LEVEL, 1e6 * SIZE])
        (tmp_path / "campaign.toml").write_text(propose([tmp_path / "s.csv"], tmp_path), encoding="utf-8")
        assert isinstance(read_campaign(tmp_path).device, device)


def test_a_sweep_without_a_point_is_one_line_of_advice() -> None:
    with pytest.raises(UserError, match="0 points are too few"):
        read_campaign({"freq (Hz)": np.zeros(0), "drive (V)": np.zeros(0), "z (um)": np.zeros(0)})


def test_the_acceleration_of_a_base_is_the_level(tmp_path: Path) -> None:
    write_table(tmp_path / "s.csv", "Frequency_Hz,Base_acceleration_g,Amplitude_um", [F, LEVEL, 1e6 * SIZE])
    campaign = read_campaign(tmp_path / "s.csv")
    assert isinstance(campaign.device, Oscillator) and campaign.device.input == "m/s^2"
    np.testing.assert_allclose(campaign.sweeps[0].level, 9.80665 * LEVEL, rtol=1e-6)
