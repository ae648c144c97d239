"""Files of instruments that nobody here owns are read, or refused with the line that would help."""

from __future__ import annotations

import json

import numpy as np
import pytest

from ident.campaign import Oscillator, Platform, read_campaign
from ident.campaign.load import read_table
from ident.campaign.propose import propose
from ident.campaign.quality.gaps import crossed_by_drive
from ident.campaign.quality.suspect import suspects_by_data
from ident.campaign.tables.clock import clock_seconds
from ident.campaign.tables.header import header_of
from ident.campaign.tables.preamble import preamble_words, step_of
from ident.campaign.tables.table import Column
from ident.errors import UserError
from tests.campaign.strangers import (
    COUNT,
    DRIVE,
    LAYOUTS,
    RESPONSE,
    SINGLE,
    STEP,
    TIME,
    lvm_segments,
    rows,
    segments,
    single,
)
from tests.end_to_end.user import assert_one_line, ident

HEADER = "time (s),drive (V),z (um)\n"


def _campaign(folder, **files):
    """The campaign that `ident new` makes of files."""
    paths = []
    for name, text in files.items():
        paths.append(folder / name.replace("_", "."))
        paths[-1].write_text(text, encoding="utf-8")
    (folder / "campaign.toml").write_text(propose(paths, folder), encoding="utf-8")
    return read_campaign(folder)


def _assert_recording(record, level=1.0):
    measured = record.response * (1e6 if np.ptp(record.response) < 1e-3 else 1.0)  # a displacement in um, or volts
    np.testing.assert_allclose(np.diff(record.time), STEP, rtol=1e-5)
    np.testing.assert_allclose(record.drive, level * DRIVE, atol=2e-5)
    np.testing.assert_allclose(measured, level * RESPONSE, atol=2e-5)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_table_of_both_channels(layout, tmp_path):
    suffix = "lvm" if "LabVIEW" in layout else "csv"
    (record,) = _campaign(tmp_path, **{f"a_{suffix}": LAYOUTS[layout]}).traces
    assert len(record.time) == COUNT
    _assert_recording(record)


@pytest.mark.parametrize("kind", SINGLE)
def test_a_file_for_each_channel(kind, tmp_path):
    campaign = _campaign(tmp_path, DS0001CH1_csv=single("CH1", kind), DS0001CH2_csv=single("CH2", kind))
    (record,) = campaign.traces
    _assert_recording(record)


@pytest.mark.parametrize("text", [segments(), lvm_segments()], ids=["bare", "with headers"])
def test_recordings_one_below_the_other_are_records(text, tmp_path):
    campaign = _campaign(tmp_path, a_lvm=text)
    assert [record.name for record in campaign.traces] == ["a.lvm #1", "a.lvm #2", "a.lvm #3"]
    assert [record.holdout for record in campaign.traces] == [False, True, False]
    for level, record in enumerate(campaign.traces, 1):
        _assert_recording(record, level)
    assert_one_line(
        ident("check", tmp_path / "a.lvm", "--columns", "drive=2,response=3"), "backwards", "segment = 1 to 3"
    )
    file = tmp_path / "campaign.toml"
    file.write_text(file.read_text(encoding="utf-8").replace("segment = 2", "segment = 4"), encoding="utf-8")
    assert_one_line(ident("check", tmp_path), "segment = 4", "holds 3")


def test_a_segment_goes_through_a_fit(tmp_path):
    (tmp_path / "a.csv").write_text(segments(), encoding="utf-8")
    assert ident("new", tmp_path / "mine", tmp_path / "a.csv").code == 0
    assert ident("check", tmp_path / "mine").code == 0
    outcome = ident("fit", tmp_path / "mine", "-o", tmp_path / "run")
    assert outcome.code == 0
    document = json.loads((tmp_path / "run" / "run.json").read_text(encoding="utf-8"))
    assert [record["file"] for record in document["records"]] == [f"../a.csv #{k}" for k in (1, 2, 3)]
    assert ident("report", tmp_path / "run").code == 0


def test_a_recording_that_falls_back_in_time_is_not_cut(tmp_path):
    times = TIME.copy()
    times[200] = times[150]
    (tmp_path / "a.csv").write_text(HEADER + rows(times, DRIVE, RESPONSE), encoding="utf-8")
    assert_one_line(ident("check", tmp_path / "a.csv"), "line 202", "runs backwards")


@pytest.mark.parametrize("cell", ["NaN", "", "∞", "-inf", "1.#IND"])
def test_samples_of_the_response_that_are_no_number_are_not_counted(cell, tmp_path):
    lines = (HEADER + rows(TIME, DRIVE, RESPONSE)).splitlines()
    for k in (100, 101, 300):
        lines[k + 1] = ",".join([*lines[k + 1].split(",")[:2], cell])
    (record,) = _campaign(tmp_path, a_csv="\n".join(lines) + "\n").traces
    assert record.masked is not None and list(np.flatnonzero(record.masked)) == [100, 101, 300]
    np.testing.assert_allclose(record.response[[100, 101, 300]], 1e-6 * RESPONSE[[100, 101, 300]], atol=1e-8)
    assert abs(record.noise.sigma / 2e-9 - 1) < 0.3
    assert any("line 102" in note and "3 samples" in note for note in read_campaign(tmp_path).notes)


def test_a_drive_is_drawn_across_gaps_only_where_that_is_harmless(tmp_path):
    def text(lost):
        lines = (HEADER + rows(TIME, DRIVE, RESPONSE)).splitlines()
        for k in lost:
            lines[k + 1] = f"{TIME[k]:.9g},NaN,NaN"
        return "\n".join(lines) + "\n"

    (record,) = _campaign(tmp_path, a_csv=text((100, 101, 102))).traces
    np.testing.assert_allclose(record.drive, DRIVE, atol=0.01 * float(np.std(DRIVE)))
    assert record.masked is not None and np.count_nonzero(record.masked) == 3
    (tmp_path / "a.csv").write_text(text(range(100, 140)), encoding="utf-8")
    assert_one_line(ident("check", tmp_path), "line 102", "column 2", "and 39 more")


def test_a_trigger_is_a_drive(tmp_path):
    rng = np.random.default_rng(2)
    drive = 5.0 * (np.sin(2 * np.pi * 480 * TIME) > 0) + 0.02 * rng.standard_normal(COUNT)
    (record,) = _campaign(tmp_path, a_csv="Time (s),CH1 (V),CH2 (V)\n" + rows(TIME, RESPONSE, drive)).traces
    np.testing.assert_allclose(record.drive, drive, atol=1e-6)


def test_a_sensitivity_above_the_table_is_said(tmp_path):
    text = "# Polytec OFV-5000, DD-300\n# Sensitivity: 5 um/V\nTime (s),Drive (V),Vibrometer (V)\n"
    campaign = _campaign(tmp_path, a_csv=text + rows(TIME, DRIVE, RESPONSE))
    assert any("5 um/V" in note and "scale = { response" in note for note in campaign.notes)


@pytest.mark.parametrize("pace, kind", [(1.0, Platform), (0.1, Platform), (0.01, Oscillator), (8.0, Oscillator)])
def test_what_a_platform_cannot_do_in_time_is_an_oscillator(pace, kind, tmp_path):
    """Volts and micrometres are those of the platform, unless its motion is too fast for the record, or too slow."""
    campaign = _campaign(tmp_path, a_csv=HEADER + rows(TIME / pace, DRIVE, RESPONSE))
    assert isinstance(campaign.device, kind)


def test_files_without_a_table_are_left_out(tmp_path):
    campaign = _campaign(tmp_path, notes_txt="the data of Monday\n", a_csv=HEADER + rows(TIME, DRIVE, RESPONSE))
    assert [record.name for record in campaign.traces] == ["a.csv"]
    assert "# left out: notes.txt: no table" in (tmp_path / "campaign.toml").read_text(encoding="utf-8")
    outcome = ident("new", tmp_path / "mine", tmp_path / "notes.txt")
    assert outcome.code == 2 and "notes.txt: no table of numbers" in outcome.err


def test_a_trace_whose_rate_is_nowhere_told_is_refused(tmp_path):
    (tmp_path / "a.csv").write_text("drive (V),z (um)\n" + rows(DRIVE, RESPONSE), encoding="utf-8")
    assert_one_line(ident("check", tmp_path / "a.csv"), "a.csv", "time")


def _arrays(**more):
    return {"u": DRIVE, "y": 1e-6 * RESPONSE, **more}


def _signals():
    axis = np.zeros(1, dtype=[("Name", object), ("Data", object)])
    axis[0] = ("Time", TIME[None])
    signals = np.zeros(2, dtype=[("Name", object), ("Data", object), ("Unit", object)])
    signals[0], signals[1] = ("drive", DRIVE[None], "V"), ("displacement", RESPONSE[None], "um")
    return {"exp_1": {"X": axis, "Y": signals}}


def _scope_data():
    signals = np.zeros(2, dtype=[("values", object), ("label", object), ("dimensions", object)])
    signals[0], signals[1] = (DRIVE[:, None], "drive", 1), (1e-6 * RESPONSE[:, None], "position", 1)
    return {"ScopeData": {"time": TIME[:, None], "signals": signals, "blockName": "m/Scope"}}


MATLAB = {
    "a rate": _arrays(Fs=20e3),
    "a step": _arrays(Ts=STEP),
    "a structure with a rate": {"data": _arrays(fs=20e3, info={"operator": "me"})},
    "dSPACE": _signals(),
    "Simulink": _scope_data(),
}


@pytest.mark.parametrize("content", MATLAB)
def test_structures_of_matlab(content, tmp_path):
    from scipy.io import savemat

    savemat(tmp_path / "a.mat", MATLAB[content])
    (tmp_path / "campaign.toml").write_text(propose([tmp_path / "a.mat"], tmp_path), encoding="utf-8")
    (record,) = read_campaign(tmp_path).traces
    _assert_recording(record)


def test_each_rate_of_a_tdms_file_has_its_own_times(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    channel = nptdms.ChannelObject
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        fast = [channel("fast", name, values, {"wf_increment": STEP, "unit_string": unit})
                for name, values, unit in (("drive", DRIVE, "V"), ("displacement", RESPONSE, "um"))]  # fmt: skip
        slow = [channel("slow", f"T{k}", np.linspace(20, 21, 20), {"wf_increment": 20 * STEP}) for k in range(4)]
        writer.write_segment([*fast, *slow])
    table = read_table(tmp_path / "a.tdms", "a.tdms")
    assert [c.header for c in table.columns] == ["time (s)", "drive", "displacement"]
    np.testing.assert_allclose(table.columns[0].numbers(), TIME)


@pytest.mark.parametrize(
    ("key", "value", "step"),
    [
        ("Sample Interval", "4e-09", 4e-9),
        ("Time interval", "0.20uS", 2e-7),
        ("Delta_X", "0,000050", 5e-5),
        ("Sample rate", "20000Hz", 5e-5),
        ("Sampling rate", "1.25 MSa/s", 8e-7),
        ("Sampling rate", "1,000,000 Hz", 1e-6),
        ("Sampling rate", "12,500.0 Hz", 8e-5),
        ("Acquisition rate", "2.0e+04 Hz, Precision mode", 5e-5),
        ("Record Length", "4000", None),
        ("Sample rate", "fast", None),
        ("Sample rate", "0", None),
        ("Frame rate", "30", None),
    ],
)
def test_what_tells_the_step(key, value, step):
    found = step_of(key, value)
    assert found is step if step is None or found is None else abs(found / step - 1) < 1e-12


def test_a_line_that_tells_a_value_is_no_header():
    assert header_of(["Min bandwidth:,0"], ",", 2).names == []
    assert header_of(["SampleRate,2.0E+04"], ",", 2).names == []
    assert header_of(["time,z", "Waveform Data,"], ",", 2).names == []
    assert list(header_of(["time,z", "-----"], ",", 2).names) == ["time", "z"]
    assert preamble_words([["Source", "CH1", "CH2"], ["XInc", "2e-6"]]).sources == ("CH1", "CH2")


def test_times_of_day():
    assert clock_seconds(["00:00:01.5", "00:00:02"]) == ["1.5", "2"]
    assert clock_seconds(["12:00:00 AM", "12:00:00 PM"]) == ["0", "43200"]
    assert clock_seconds(["05:33.5", "noon"]) is None


@pytest.mark.parametrize(
    ("cells", "seconds"),
    [
        (["59:59.8", "59:59.9", "00:00.0", "00:00.1"], ["3599.8", "3599.9", "3600.0", "3600.1"]),
        (["59:59.9", "1:00:00.0"], ["3599.9", "3600.0"]),
        (["59:59", "60:00", "99:59", "10:00"], ["3599", "3600", "5999", "600"]),  # it counts minutes on
        (["12:59:59", "01:00:00", "12:00:00", "01:00:00"], ["46799", "46800", "86400", "90000"]),
        (["11:59:59", "12:00:00"], ["43199", "43200"]),
        (["11:59:59 AM", "12:00:00 PM", "11:59:59 PM", "12:00:00 AM"], ["43199", "43200", "86399", "86400"]),
        (["23:59:59", "00:00:00"], ["86399", "86400"]),
        (["00:59:59", "12:59:59", "01:00:00"], ["3599", "46799", "3600"]),  # a clock of 24 hours that was set back
    ],
)
def test_a_clock_begins_anew_after_its_largest_field(cells, seconds):
    assert clock_seconds(cells) == seconds


def _without(text, lost):
    """A table without some of its rows, counted from the first below the header."""
    lines = text.splitlines()
    return "\n".join(line for k, line in enumerate(lines) if k - 1 not in lost) + "\n"


def test_gaps_in_a_drive_are_crossed_wherever_they_lie():
    time = np.arange(1200) / 500.0
    drive = np.sin(2 * np.pi * 20 * time)
    for lost in ([100, 130, 1070], [137, 500, 900], [300, 400, 1066]):  # moved, some of them come to lie at an end
        gone = np.isin(np.arange(1200), lost)
        assert crossed_by_drive(Column("a.csv", "drive_V", "drive", "V", 2, drive[~gone]), ~gone)
    middle = np.abs(np.arange(1200) - 600) < 20  # nearly two periods, as far from the ends as can be
    assert not crossed_by_drive(Column("a.csv", "drive_V", "drive", "V", 2, drive[~middle]), ~middle)
    one = np.arange(1200) == 600
    assert crossed_by_drive(Column("a.csv", "drive_V", "drive", "V", 2, drive[~one]), ~one)
    holed = np.where(np.arange(1200) == 700, np.nan, drive)  # one that is no number counts as one that is lost
    assert crossed_by_drive(Column("a.csv", "drive_V", "drive", "V", 2, holed[~gone]), ~gone)
    gone = np.isin(np.arange(1200), np.arange(1, 13))
    assert not crossed_by_drive(Column("a.csv", "drive_V", "drive", "V", 2, drive[~gone]), ~gone)


def test_frames_that_a_camera_lost_are_not_counted(tmp_path):
    """Their numbers and times jump by whole intervals, printed to a millisecond; the frame is no drive."""
    time, lost = np.arange(400) / 30.0, {7, 50, 51, 333}
    noise = 0.05 * np.random.default_rng(5).standard_normal(400)
    angle = np.round(40 * np.exp(-time / 8) * np.cos(5.0 * time) + noise, 2)
    cells = "".join(f"{k},{t:.3f},{z:.2f}\n" for k, (t, z) in enumerate(zip(time, angle, strict=True)))
    campaign = _campaign(tmp_path, a_csv=_without("frame,t_s,angle_deg\n" + cells, lost))
    (record,) = campaign.traces
    assert not record.driven and len(record.time) == 400
    assert record.masked is not None and set(np.flatnonzero(record.masked)) == lost
    np.testing.assert_allclose(np.diff(record.time), 1 / 30, rtol=1e-4)
    assert any("line 9" in note and "4 samples" in note for note in campaign.notes)
    assert abs(record.noise.sigma / np.radians(0.05) - 1) < 0.15 and record.noise.relative_error < 0.2
    assert not suspects_by_data(campaign)  # to have lost some is no fault of the others


def test_a_drive_is_drawn_across_lost_samples_only_where_that_is_harmless(tmp_path):
    text = HEADER + rows(TIME, DRIVE, RESPONSE)
    (record,) = _campaign(tmp_path, a_csv=_without(text, {100, 101, 102})).traces
    assert record.masked is not None and list(np.flatnonzero(record.masked)) == [100, 101, 102]
    np.testing.assert_allclose(record.drive, DRIVE, atol=0.01 * float(np.std(DRIVE)))


def test_where_nobody_knows_the_drive_a_record_ends_and_another_begins_in_motion(tmp_path):
    text = HEADER + rows(TIME, DRIVE, RESPONSE)
    lost = {50, *range(100, 140), 300}
    campaign = _campaign(tmp_path, a_csv=_without(text, lost))
    first, second = campaign.traces
    assert (first.name, second.name) == ("a.csv", "a.csv, stretch 2")
    assert (len(first.time), len(second.time)) == (100, 260)
    assert list(np.flatnonzero(first.counted == 0)) == [50] and list(np.flatnonzero(second.counted == 0)) == [160]
    assert second.begins_in_motion and second.into == pytest.approx(TIME[140] - TIME[0])
    assert any("the recorder stopped on the way" in note for note in campaign.notes)
    assert campaign.said is not None and [name for name, _ in campaign.said.records] == [first.name, second.name]


def test_lost_samples_are_seen_among_uneven_ones(tmp_path):
    """Every interval differs by up to 12 %, so that two or three of them are no whole number of the usual."""
    rng, lost = np.random.default_rng(11), {100, 230, 231}
    time = np.cumsum(0.004 * (1 + rng.uniform(-0.12, 0.12, 600)))
    drive = np.sin(2 * np.pi * 3.4 * time) + 0.003 * rng.standard_normal(600)
    response = np.cos(2 * np.pi * 3.4 * time) + 0.01 * rng.standard_normal(600)
    text = "time (s),drive (V),z (um)\n" + rows(time, drive, response)
    (record,) = _campaign(tmp_path, a_csv=_without(text, lost)).traces
    assert record.masked is not None
    gone = np.flatnonzero(record.masked)  # on the uniform grid, where the others are interpolated from the uneven rows
    assert all(np.min(np.abs(record.time[gone] - time[row])) < 0.002 for row in lost) and len(gone) <= 6
    assert np.max(np.abs(record.drive - np.sin(2 * np.pi * 3.4 * record.time))) < 0.02
    silent = "time (s),drive (V),z (um)\n" + rows(time, 0 * drive, response)
    (decay,) = _campaign(tmp_path, b_csv=_without(silent, lost)).traces
    assert not decay.driven and decay.masked is not None


def test_beside_a_response_that_is_named_the_other_signal_is_the_drive(tmp_path):
    """A device smooths what drives it: of two signals the smoother need not be the drive."""
    rng = np.random.default_rng(3)
    drive = rng.standard_normal(COUNT)
    output = np.convolve(drive, np.exp(-np.arange(40) / 8.0))[:COUNT]
    text = "t [s],table acceleration [mm/s2],output [mV]\n" + rows(TIME, drive, output)
    campaign = _campaign(tmp_path, a_csv=text)
    assert isinstance(campaign.device, Oscillator) and campaign.device.output == "V"
    np.testing.assert_allclose(campaign.traces[0].drive, 1e-3 * drive, rtol=1e-4, atol=1e-7)


_OSCILLATOR = 'device = {{ kind = "oscillator" }}\n\n[[record]]\nfile = "a.csv"\n{more}'


@pytest.mark.parametrize(
    ("header", "more"),
    [
        ("t (s),load cell (N),tip (mm)", ""),
        ("t_s,F_N,x_mm", ""),
        ("time (s),wheel pan [mm],body acceleration (g)", 'measures = "acceleration"\n'),
        ("time (s),a_base (m/s2),z (mm)", ""),
        ("Time (s),Base accel (m/s2),Rel velocity (mm/s)", 'measures = "velocity"\n'),
        ("t (s),Hammer force (N),Floor accel (g)", 'measures = "acceleration"\n'),
        ("t (s),Motor current (A),Mount acceleration (m/s2)", 'measures = "acceleration"\n'),
        ("t (s),Base acceleration (m/s2),Floor acceleration (m/s2)", 'measures = "acceleration"\n'),
        ("time (s),amp_out (V),pos (mm)", ""),  # an amplifier's output, which is what goes in
    ],
)
def test_the_only_column_left_in_a_unit_of_what_drives_is_the_drive(header, more, tmp_path):
    (tmp_path / "a.csv").write_text(header + "\n" + rows(TIME, DRIVE, RESPONSE))
    (tmp_path / "campaign.toml").write_text(_OSCILLATOR.format(more=more))
    (record,) = read_campaign(tmp_path).traces
    scale = 1e-3 if "[mm]" in header else 1.0
    np.testing.assert_allclose(record.drive, scale * DRIVE, atol=2e-5)
    if "(g)" in header:
        np.testing.assert_allclose(record.response, 9.80665 * RESPONSE, atol=2e-4)


def test_a_temperature_is_no_drive(tmp_path):
    (tmp_path / "a.csv").write_text("t (s),z (mm),box (K)\n" + rows(TIME, RESPONSE, DRIVE + 300))
    (tmp_path / "campaign.toml").write_text(_OSCILLATOR.format(more=""))
    with pytest.raises(UserError, match="drive"):
        read_campaign(tmp_path)


def test_decays_may_come_before_the_first_record_that_states_the_unit_of_the_drive(tmp_path):
    (tmp_path / "a.csv").write_text("t (s),z (mm)\n" + rows(TIME, RESPONSE))
    (tmp_path / "b.csv").write_text("t (s),force (N),z (mm)\n" + rows(TIME, DRIVE, RESPONSE))
    (tmp_path / "campaign.toml").write_text(_OSCILLATOR.format(more='\n[[record]]\nfile = "b.csv"\n'))
    free, driven = read_campaign(tmp_path).traces
    assert not np.any(free.drive)
    np.testing.assert_allclose(driven.drive, DRIVE, atol=2e-5)
