"""Files as instruments write them, made from one recording: `(kind, writer(folder) -> files)`.

The layouts follow the makers' manuals and files that their users have published; the numbers are ours.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

RATE, COUNT = 50e3, 2000
TIME = np.arange(COUNT) / RATE
DRIVE = np.round(4.0 * np.sin(2 * np.pi * 500 * TIME), 4)
RESPONSE = np.round(
    1.5 * np.sin(2 * np.pi * 500 * TIME - 1.2) + 0.004 * np.random.default_rng(3).standard_normal(COUNT), 4
)
EARLY = TIME - 0.01  # a scope's time is zero at its trigger


def _write(folder: Path, name: str, text: str) -> list[Path]:
    path = folder / name
    path.write_bytes(text.encode("utf-8"))
    return [path]


def _rows(*columns: np.ndarray, separator: str = ",", form: str = "{:.9g}", end: str = "\n") -> str:
    return "".join(separator.join(form.format(x) for x in row) + end for row in zip(*columns, strict=True))


def tektronix_tds(folder: Path) -> list[Path]:
    """TDS2000: a file per channel, its preamble beside the first rows."""
    files = []
    for channel, values in (("CH1", DRIVE), ("CH2", RESPONSE)):
        told = [
            ("Record Length", f"{COUNT:.6e}"), ("Sample Interval", "2.000000e-05"), ("Trigger Point", "500"), ("", ""),
            ("", ""), ("", ""), ("Source", channel), ("Vertical Units", "V"), ("Vertical Scale", "1.0e+00"),
            ("Vertical Offset", "0.0"), ("Horizontal Units", "s"), ("Horizontal Scale", "2.5e-03"),
            ("Pt Fmt", "Y"), ("Yzero", "0.0"), ("Probe Atten", "1.0"), ("Model Number", "TDS2012B"),
            ("Serial Number", "C051234"), ("Firmware Version", "FV:v22.01"),
        ]  # fmt: skip
        lines = []
        for k in range(COUNT):
            key, value = told[k] if k < len(told) else ("", "")
            lines.append(f"{key},{value},,{EARLY[k]: .12f},{values[k]: .5f},")
        files += _write(folder, f"F0003{channel}.CSV", "\r\n".join(lines) + "\r\n")
    return files


def tektronix_mso(folder: Path) -> list[Path]:
    head = (
        "Model,MSO54\nFirmware Version,1.30\n\nPoint Format,Y,,\nHorizontal Units,s,,\nHorizontal Scale,0.004,,\n"
        f"Sample Interval,2e-05,,\nRecord Length,{COUNT},,\nProbe Attenuation,1,1\nVertical Units,V,V\n"
        "Vertical Offset,0,0\nVertical Scale,1,1\nLabel,,\nTIME,CH1,CH2\n"
    )
    return _write(folder, "Tek000.csv", head + _rows(EARLY, DRIVE, RESPONSE))


def keysight(folder: Path) -> list[Path]:
    rows = _rows(EARLY, DRIVE, RESPONSE, form="{:+.8E}")
    return _write(folder, "scope_0.csv", "x-axis,1,2\nsecond,Volt,Volt\n" + rows)


def rigol(folder: Path) -> list[Path]:
    head = "X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-1.000000e-02,2.000000e-05\n"
    return _write(folder, "NewFile1.csv", head + _rows(np.arange(COUNT), DRIVE, RESPONSE, end=",,\n"))


def siglent(folder: Path) -> list[Path]:
    head = (
        f"Record Length,Analog:{COUNT}\nSample Interval,Analog:0.00002\nVertical Units,CH1:V CH2:V\n"
        "Vertical Scale,CH1:1.00 CH2:0.50\nHorizontal Units,s\nHorizontal Scale,0.004\nModel Number,SDS1104X-E\n"
        "Serial Number,SDSM0000000001\nSoftware Version,8.2.6.1.37R9\nSource,CH1,CH2\nSecond,Volt,Volt\n"
    )
    return _write(folder, "SDS00001.csv", head + _rows(EARLY, DRIVE, RESPONSE))


def lecroy(folder: Path) -> list[Path]:
    files = []
    for name, values in (("C1Trace00000.csv", DRIVE), ("C2Trace00000.csv", RESPONSE)):
        head = (
            f"LECROYWR64Xi,12345,Waveform\nSegments,1,SegmentSize,{COUNT}\nSegment,TrigTime,TimeSinceSegment1\n"
            "#1,05-Mar-2024 13:05:33,0\nTime,Ampl\n"
        )
        files += _write(folder, name, head + _rows(EARLY, values))
    return files


def picoscope(folder: Path) -> list[Path]:
    head = "Time,Channel A,Channel B\n(ms),(V),(V)\n\n"
    return _write(folder, "pico.csv", head + _rows(1e3 * EARLY, DRIVE, RESPONSE, form="{:.8f}"))


def polytec(folder: Path) -> list[Path]:
    head = (
        "Polytec Vibrometer Software\nScan Point 12\nAVG\n\nSignal\tReference\tVibrometer\n\n"
        "Time\tReference1 Voltage\tVib Displacement\n[ s ]\t[ V ]\t[ um ]\n"
    )
    return _write(folder, "point_12.txt", head + _rows(TIME, DRIVE, RESPONSE, separator="\t"))


def labview(folder: Path) -> list[Path]:
    head = (
        "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n"
        "Multi_Headings\tNo\nX_Columns\tOne\nTime_Pref\tRelative\nOperator\tlab\nDate\t2024/03/05\n"
        "Time\t13:05:33.512\n***End_of_Header***\t\n\t\t\nChannels\t2\t\t\nSamples\t2000\t2000\t\n"
        "Date\t2024/03/05\t2024/03/05\t\nTime\t13:05:33.5\t13:05:33.5\t\nY_Unit_Label\tVolts\tVolts\t\n"
        "X_Dimension\tTime\tTime\t\nX0\t0.0000000000000000E+0\t0.0000000000000000E+0\t\n"
        "Delta_X\t2.000000E-5\t2.000000E-5\t\n***End_of_Header***\t\t\t\nX_Value\tDrive\tVibrometer\tComment\n"
    )
    return _write(folder, "run_7.lvm", head + _rows(TIME, DRIVE, RESPONSE, separator="\t", end="\t\n"))


def tektronix_isf(folder: Path) -> list[Path]:
    """Internal save format: a file per channel of 16-bit counts."""
    files = []
    for channel, values in (("CH1", DRIVE), ("CH2", RESPONSE)):
        counts = np.round(values / 2e-4).astype(">i2").tobytes()
        head = (
            f":WFMPRE:BYT_NR 2;BIT_NR 16;ENCDG BIN;BN_FMT RI;BYT_OR MSB;NR_PT {COUNT};"
            f'WFID "{channel}, DC coupling, 1.0E0 V/div";PT_FMT Y;XINCR 2.0E-5;PT_OFF 0;XZERO -1.0E-2;XUNIT "s";'
            f'YMULT 2.0E-4;YZERO 0.0E0;YOFF 0.0E0;YUNIT "V";:CURVE #{len(str(len(counts)))}{len(counts)}'
        )
        path = folder / f"tek0001{channel}.isf"
        path.write_bytes(head.encode("ascii") + counts)
        files.append(path)
    return files


def universal(folder: Path) -> list[Path]:
    import pyuff

    path = folder / "measured.uff"
    axes = ("abscissa", "ordinate", "orddenom", "z_axis")
    exponents = {f"{axis}_{of}_unit_exp": 0 for axis in axes for of in ("len", "force", "temp")}
    sets = []
    for k, (name, unit, kind, values) in enumerate(
        (("drive", "V", 0, DRIVE), ("displacement", "m", 8, 1e-6 * RESPONSE)), 1
    ):
        told = pyuff.prepare_58(
            binary=0, func_type=1, id1=name, id2="", id3="", id4="", id5="", ver_num=0, load_case_id=0,
            rsp_ent_name=name, rsp_node=k, rsp_dir=3, ref_ent_name="NONE", ref_node=1, ref_dir=3, ord_data_type=4,
            num_pts=COUNT, abscissa_spacing=1, abscissa_min=0.0, abscissa_inc=1 / RATE, z_axis_value=0.0,
            abscissa_spec_data_type=17, abscissa_axis_units_lab="s", ordinate_spec_data_type=kind,
            ordinate_axis_units_lab=unit, orddenom_spec_data_type=0, orddenom_axis_units_lab="NONE",
            z_axis_spec_data_type=0, z_axis_axis_units_lab="NONE", data=values, x=TIME, **exponents,
        )  # fmt: skip
        sets.append(told)
    pyuff.UFF(str(path)).write_sets(sets, "overwrite")
    return [path]


def numpy_arrays(folder: Path) -> list[Path]:
    np.savez(folder / "run.npz", time_s=TIME, drive_V=DRIVE, z_um=RESPONSE)
    return [folder / "run.npz"]


def tdms(folder: Path) -> list[Path]:
    import nptdms

    with nptdms.TdmsWriter(folder / "run.tdms") as writer:
        told = {"wf_increment": 1 / RATE, "wf_start_offset": 0.0}
        writer.write_segment(
            [
                nptdms.ChannelObject("DAQ", name, values, {**told, "unit_string": unit})
                for name, values, unit in (("drive", DRIVE, "V"), ("displacement", RESPONSE, "um"))
            ]
        )
    return [folder / "run.tdms"]


def matlab(folder: Path) -> list[Path]:
    from scipy.io import savemat

    savemat(folder / "run.mat", {"t_s": TIME, "u_V": DRIVE, "z_um": RESPONSE, "comment": "device 12"})
    return [folder / "run.mat"]


KINDS: dict[str, tuple[Callable[[Path], list[Path]], str]] = {
    "Tektronix TDS, a file per channel": (tektronix_tds, ""),
    "Tektronix MSO": (tektronix_mso, ""),
    "Keysight InfiniiVision": (keysight, ""),
    "Rigol DS1000Z": (rigol, ""),
    "Siglent SDS": (siglent, ""),
    "LeCroy, a file per channel": (lecroy, ""),
    "PicoScope": (picoscope, ""),
    "Polytec": (polytec, ""),
    "LabVIEW": (labview, ""),
    "Tektronix ISF": (tektronix_isf, "RigolWFM"),
    "universal file 58": (universal, "pyuff"),
    "NumPy": (numpy_arrays, ""),
    "TDMS": (tdms, "nptdms"),
    "MATLAB": (matlab, ""),
}
"""Every kind, with the optional library that it needs."""
