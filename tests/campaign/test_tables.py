"""Tables in every usual style, and the columns in them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ident.campaign.load import read_table
from ident.campaign.tables.columns import match_columns, sweep_roles, trace_roles
from ident.campaign.tables.table import split_header
from ident.campaign.tables.text import decode, parse_text_table
from ident.errors import UserError
from ident.units import LENGTH, VOLTAGE

PLATFORM = trace_roles(VOLTAGE, LENGTH)
ELECTRIC = trace_roles(VOLTAGE, VOLTAGE)
SWEEP = sweep_roles(VOLTAGE, LENGTH)


@pytest.mark.parametrize(
    ("header", "stem", "unit"),
    [
        ("Acceleration_m/s^2", "Acceleration", "m/s^2"),
        ("acceleration_m_s2", "acceleration", "m/s^2"),
        ("a_ms-2", "a", "m/s^2"),
        ("v_mm_per_s", "v", "mm/s"),
        ("speed_mps", "speed", "m/s"),
        ("acc_g", "acc", "g_n"),
        ("Accel [g]", "Accel", "g_n"),
        ("time_ms", "time", "ms"),
        ("v in mm/s", "v", "mm/s"),
        ("time (s)", "time", "s"),
        ("t [ms]", "t", "ms"),
        ("Time_us", "Time", "us"),
        ("Drive_mV", "Drive", "mV"),
        ("z [um]", "z", "um"),
        ("Displacement_nm", "Displacement", "nm"),
        ("amplitude (µm)", "amplitude", "µm"),
        ("amplitude (μm)", "amplitude", "μm"),
        ("phase (deg)", "phase", "deg"),
        ("t_s", "t", "s"),
        ('"Time, s"', "Time", "s"),
        ("Weg in µm", "Weg", "µm"),
        ("z / µm", "z", "µm"),
        ("z/um", "z", "um"),
        ("TIME_MS", "TIME", "ms"),
        ("DRIVE_MV", "DRIVE", "mV"),
        ("F_kN", "F", "kN"),
        ("FORCE_KN", "FORCE", "kN"),
        ("stroke_cm", "stroke", "cm"),
        ("drive {V}", "drive", "V"),
        ("rate (rad/s)", "rate", "rad/s"),
        ("level (Vpp)", "level", "Vpp"),
        ("V_in", "V_in", None),
        ("Channel A", "Channel A", None),
        ("CH1", "CH1", None),
        ("Drive (CH1)", "Drive", None),
        ("y_meas", "y_meas", None),
    ],
)
def test_headers(header, stem, unit):
    assert split_header(header)[:2] == (stem, unit)


def _table(header: str, rows: int = 4):
    row = ",".join(["1"] * len(header.split(",")))
    return parse_text_table("\n".join([header] + [row] * rows), "x.csv")


@pytest.mark.parametrize(
    ("header", "roles", "expected"),
    [
        ("time (s),Drive_mV,z [um]", PLATFORM, ("time (s)", "Drive_mV", "z [um]")),
        ("z (um),u (V),t (s)", PLATFORM, ("t (s)", "u (V)", "z (um)")),
        ("t_s,u_V,y_V", ELECTRIC, ("t_s", "u_V", "y_V")),
        ("t (s),CH1 (V),CH2 (um)", PLATFORM, ("t (s)", "CH1 (V)", "CH2 (um)")),
        ("time (s),V_in (V),V_out (V)", ELECTRIC, ("time (s)", "V_in (V)", "V_out (V)")),
        ("time,voltage,displacement", PLATFORM, ("time", "voltage", "displacement")),
        ("Zeit (s),Spannung (V),Weg (um)", PLATFORM, ("Zeit (s)", "Spannung (V)", "Weg (um)")),
        ("t (s),drive (V),z (um),velocity (mm/s)", PLATFORM, ("t (s)", "drive (V)", "z (um)")),
        ("n,time (s),drive (V),z (um),temperature (K)", PLATFORM, ("time (s)", "drive (V)", "z (um)")),
        ("Time (s),Voltage (V),Z (um),Drive current (mA)", PLATFORM, ("Time (s)", "Voltage (V)", "Z (um)")),
    ],
)  # fmt: skip
def test_columns_are_matched_by_meaning(header, roles, expected):
    found = match_columns(_table(header), roles, {}, {})
    assert tuple(found[role].header for role in ("time", "drive", "response")) == expected


@pytest.mark.parametrize(
    ("header", "drive", "response"),
    [("t (ms),I (mA),v (mm/s)", "I (mA)", "v (mm/s)"), ("t (s),F (N),u (mm)", "F (N)", "u (mm)"),
     ("t (s),U (V),u (um)", "U (V)", "u (um)")],
)  # fmt: skip
def test_a_letter_in_a_unit_of_motion_beside_what_pushes_is_the_response(header, drive, response):
    """A current was read as what answers, and the velocity as what drives: both drives are called v."""
    free = tuple(replace(role, dimension=None) for role in ELECTRIC)
    found = match_columns(_table(header), free, {}, {})
    assert (found["drive"].header, found["response"].header) == (drive, response)


def test_a_letter_in_a_unit_of_motion_drives_where_a_motion_drives():
    found = match_columns(_table("t (s),u (mm),F (N),y (mm)"), trace_roles(LENGTH, LENGTH), {}, {})
    assert (found["drive"].header, found["response"].header) == ("u (mm)", "y (mm)")
    found = match_columns(_table("f (Hz),u (mm),y (V)"), sweep_roles(LENGTH, VOLTAGE), {}, {})
    assert (found["level"].header, found["amplitude"].header) == ("u (mm)", "y (V)")


def test_the_columns_of_a_sweep():
    found = match_columns(_table("frequency (Hz),drive (V),amplitude (µm),phase (deg)"), SWEEP, {}, {})
    assert set(found) == {"frequency", "level", "amplitude", "phase"}
    header = "drive_level,sweep_dir,freq_Hz,amp_V,model_published_amp_V"
    found = match_columns(_table(header), sweep_roles(VOLTAGE, VOLTAGE), {}, {})
    names = {role: column.header for role, column in found.items()}
    assert names == {"frequency": "freq_Hz", "direction": "sweep_dir", "level": "drive_level", "amplitude": "amp_V"}


@pytest.mark.parametrize(
    "header", ["t,CH1,CH2", "t (s),CH1 (V),CH2 (V)", "time (s),drive (V),z1 (um),z2 (um)", "t,A,B"]
)
def test_an_ambiguous_table_says_which_line_settles_it(header):
    with pytest.raises(UserError) as caught:
        match_columns(_table(header), PLATFORM, {}, {})
    message = str(caught.value)
    assert "columns = { time =" in message and "response =" in message
    for name in header.split(","):
        assert f'"{name}"' in message


def test_the_campaign_settles_it():
    given = {"time": "t", "drive": "CH1", "response": 3}
    found = match_columns(_table("t,CH1,CH2"), PLATFORM, given, {"response": "um", "CH1": "mV"})
    assert [(c.header, c.unit) for c in found.values()] == [("t", None), ("CH1", "mV"), ("CH2", "um")]


NUMBERS = [(0.0, 1.5, -2.5), (0.1, 2.5, 3.25), (0.2, 3.5, 4.0), (0.3, 4.5, 5.0)]


def _rows(separator: str, decimal: str = ".", end: str = "") -> str:
    return "\n".join(separator.join(str(v).replace(".", decimal) for v in row) + end for row in NUMBERS) + "\n"


STYLES = {
    "comma": "time (s),drive (V),z (um)\n" + _rows(","),
    "comma and blank": "time (s), drive (V), z (um)\n" + _rows(", "),
    "semicolon": "time (s);drive (V);z (um)\n" + _rows(";"),
    "decimal comma": "time (s);drive (V);z (um)\n" + _rows(";", ","),
    "tab": "time (s)\tdrive (V)\tz (um)\n" + _rows("\t"),
    "tab, decimal comma": "time (s)\tdrive (V)\tz (um)\n" + _rows("\t", ","),
    "blanks": "t_s u_V z_um\n" + _rows("   "),
    "blanks, decimal comma": "t_s u_V z_um\n" + _rows("  ", ","),
    "windows": ("time (s),drive (V),z (um)\n" + _rows(",")).replace("\n", "\r\n"),
    "old mac": ("time (s),drive (V),z (um)\n" + _rows(",")).replace("\n", "\r"),
    "quoted": '"time (s)","drive (V)","z (um)"\n' + _rows(","),
    "quoted commas": '"Time, s","Drive, V","z, um"\n' + _rows(","),
    "comments": "# device 12\n# 21 May\ntime (s),drive (V),z (um)\n" + _rows(",") + "# end\n",
    "header in a comment": "# measured today\n# time (s), drive (V), z (um)\n" + _rows(","),
    "percent comments": "% device 12\n% t [s]\tu [V]\tz [um]\n" + _rows("\t"),
    "row of units": "time,drive,z\ns,V,um\n" + _rows(","),
    "row of units in brackets": "Time,Drive,Displacement\n(s),(V),(um)\n\n" + _rows(","),
    "trailing separator": "time (s),drive (V),z (um),\n" + _rows(",", end=","),
    "key-value preamble": "Model,MSO54\nRecord Length,4\n\ntime (s),drive (V),z (um)\n" + _rows(","),
    "labview": "LabVIEW Measurement\nSeparator\tTab\n***End_of_Header***\ntime (s)\tdrive (V)\tz (um)\n" + _rows("\t"),
}  # fmt: skip


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_styles(style, encoding):
    table = parse_text_table(decode(STYLES[style].replace("um", "µm").encode(encoding), "x.csv"), "x.csv")
    found = match_columns(table, PLATFORM, {}, {})
    values = np.column_stack([found[role].numbers() for role in ("time", "drive", "response")])
    np.testing.assert_array_equal(values, NUMBERS)
    assert [found[role].unit for role in ("time", "drive", "response")] == ["s", "V", "µm"]


def test_tektronix():
    text = "Model,MSO54\nHorizontal Units,s\nSample Interval,4e-09\nVertical Units,V,,V\nLabel,,,\nTIME,CH1,CH2\n"
    columns = parse_text_table(text + _rows(","), "x.csv").columns
    assert [(c.header, c.unit) for c in columns] == [("TIME", "s"), ("CH1", "V"), ("CH2", "V")]


def test_keysight():
    columns = parse_text_table("x-axis,1,2\nsecond,Volt,Volt\n" + _rows(","), "x.csv").columns
    assert [(c.header, c.unit) for c in columns] == [("x-axis", "second"), ("1", "Volt"), ("2", "Volt")]


def test_rigol_counts_samples():
    text = "X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-1.2e-3,1e-6\n0,1,2,,\n1,2,3,,\n2,3,4,,\n"
    table = parse_text_table(text, "x.csv")
    assert [c.header for c in table.columns] == ["time (s)", "CH1", "CH2"]
    np.testing.assert_allclose(table.columns[0].numbers(), -1.2e-3 + 1e-6 * np.arange(3))


def test_a_column_of_words_is_kept():
    table = parse_text_table("f (Hz),direction,amplitude (um)\n1,up,2\n2,up,3\n3,down,2\n", "x.csv")
    assert list(table.columns[1].cells) == ["up", "up", "down"]


def _arrays() -> dict[str, np.ndarray]:
    time, drive, response = np.array(NUMBERS).T
    return {"time_s": time, "drive_V": drive, "z_um": response}


def _write(path, kind):
    arrays = _arrays()
    if kind == "mat":
        from scipy.io import savemat

        savemat(path, {**arrays, "comment": "x", "fs": 10.0})
    elif kind == "mat struct":
        from scipy.io import savemat

        savemat(path, {"data": arrays})
    elif kind in ("h5", "nc", "mat 7.3"):
        import h5py

        with h5py.File(path, "w") as file:
            for name, unit in (("time", "s"), ("drive", "V"), ("z", "um")):
                file[f"run/{name}"] = next(v for k, v in arrays.items() if k.startswith(name))
                file[f"run/{name}"].attrs["units"] = unit
    elif kind == "parquet":
        import pyarrow
        import pyarrow.parquet

        pyarrow.parquet.write_table(pyarrow.table(arrays), path)
    else:
        import nptdms

        with nptdms.TdmsWriter(path) as writer:
            for name, unit, values in zip(("time", "drive", "z"), ("s", "V", "um"), arrays.values(), strict=True):
                writer.write_segment([nptdms.ChannelObject("run", name, values, {"unit_string": unit})])


KINDS = {
    "mat": "",
    "mat struct": "",
    "mat 7.3": "h5py",
    "h5": "h5py",
    "nc": "h5py",
    "parquet": "pyarrow",
    "tdms": "nptdms",
}


@pytest.mark.parametrize("kind", KINDS)
def test_binary_files(kind, tmp_path):
    if KINDS[kind]:
        pytest.importorskip(KINDS[kind])
    path = tmp_path / f"a.{kind.split()[0]}"
    _write(path, kind)
    found = match_columns(read_table(path, path.name), PLATFORM, {}, {})
    values = np.column_stack([found[role].numbers() for role in ("time", "drive", "response")])
    np.testing.assert_array_equal(values, NUMBERS)
    assert [found[role].unit for role in ("time", "drive", "response")] == ["s", "V", "um"]


@pytest.mark.parametrize("suffix", ["h5", "nc", "parquet", "tdms"])
def test_a_missing_library_says_what_to_install(suffix, tmp_path, monkeypatch):
    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr("ident.errors.importlib.import_module", missing)
    path = tmp_path / f"a.{suffix}"
    path.write_bytes(b"x")
    with pytest.raises(UserError, match=r"in the folder of ident: pip install '\.\[files\]'"):
        read_table(path, path.name)


@pytest.mark.parametrize("style", STYLES)
def test_pandas_and_the_hand_read_the_same(style, monkeypatch):
    tables = []
    for least in (1 << 30, 0):
        monkeypatch.setattr("ident.campaign.tables.text.LEAST_FOR_PANDAS", least)
        tables.append(parse_text_table(decode(STYLES[style].encode("utf-8"), "x.csv"), "x.csv").columns)
    by_hand, by_pandas = tables
    assert [(c.header, c.unit, c.position) for c in by_hand] == [(c.header, c.unit, c.position) for c in by_pandas]
    for one, other in zip(by_hand, by_pandas, strict=True):
        np.testing.assert_array_equal(one.numbers(), other.numbers())
