"""Tables as instruments and laboratories write them, of one recording: `LAYOUTS`, a name to a function of text.

After exports that their users have published: GW Instek, Owon, Hantek, Keysight Infiniium, Rigol MSO5000, Yokogawa,
Tektronix, Moku, PicoScope, LabVIEW, Polytec; and what people do to tables themselves.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

STEP, COUNT = 5e-5, 400
TIME = STEP * np.arange(COUNT)
DRIVE = np.round(4.0 * np.sin(2 * np.pi * 480 * TIME), 4)
RESPONSE = np.round(
    0.5 * np.sin(2 * np.pi * 480 * TIME - 1.2) + 0.002 * np.random.default_rng(3).standard_normal(COUNT), 5
)


def rows(*columns: np.ndarray, separator: str = ",", end: str = "\n", form: str = "{:.9g}") -> str:
    return "".join(separator.join(form.format(x) for x in row) + end for row in zip(*columns, strict=True))


def _stamps(form: Callable[[float], str]) -> str:
    cells = [form(33.0 + t) for t in TIME]
    return "".join(f"{c},{u},{z}\n" for c, u, z in zip(cells, DRIVE, RESPONSE, strict=True))


_LVM = (
    "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nMulti_Headings\tNo\nX_Columns\t{x}\n"
    "Time\t17:18:18{d}9389\n***End_of_Header***\t\n\t\n"
)
_LVM_SEGMENT = (
    "Channels\t2{t}\t\t\nSamples\t400\t{t}400\t\nTime\t17:18:18{d}93\t{t}17:18:18{d}93\t\nY_Unit_Label\tVolts\t{t}Volts\t\n"
    "X_Dimension\tTime\t{t}Time\t\nX0\t0{d}0E+0\t{t}0{d}0E+0\t\nDelta_X\t0{d}000050\t{t}0{d}000050\t\n"
    "***End_of_Header***\t\t\t\n"
)


def lvm_without_x() -> str:
    """No X columns: the first column is empty, and Delta_X tells the time; decimal commas."""
    body = rows(DRIVE, RESPONSE, separator="\t", form="{:.6f}").replace(".", ",")
    head = (_LVM + _LVM_SEGMENT).format(x="No", d=",", t="") + "X_Value\tDrive\tVibrometer\tComment\n"
    return head + "".join(f"\t{line}\n" for line in body.splitlines())


def lvm_with_x_for_each() -> str:
    head = (_LVM + _LVM_SEGMENT).format(x="Multi", d=".", t="\t") + "X_Value\tDrive\tX_Value\tVibrometer\tComment\n"
    return head + rows(TIME, DRIVE, TIME, RESPONSE, separator="\t", end="\t\n")


def lvm_segments(count: int = 3) -> str:
    """A header above each of several recordings; the k-th has a drive k times as large."""
    segment = _LVM_SEGMENT.format(d=".", t="") + "X_Value\tDrive\tVibrometer\tComment\n"
    parts = [segment + rows(TIME, k * DRIVE, k * RESPONSE, separator="\t", end="\t\n") for k in range(1, count + 1)]
    return _LVM.format(x="One", d=".") + "\n".join(parts)


def segments(count: int = 3) -> str:
    """Time that starts again, without a word between."""
    parts = [rows(TIME, k * DRIVE, k * RESPONSE) for k in range(1, count + 1)]
    return "time (s),CH1 (V),CH2 (V)\n" + "".join(parts)


_TABLE = "Time (s),CH1 (V),CH2 (V)\n" + rows(TIME, DRIVE, RESPONSE)

LAYOUTS: dict[str, str] = {
    "Owon": (
        "Channel\t\t\t  :,CH1,CH2\nFrequency\t\t\t  :,F=480.0Hz,F=480.0Hz\nPK-PK\t\t\t\t  :,Vpp=8.000V,Vpp=1.0V\n"
        "Probe attenuation\t  :,1X,1X\nTime interval\t\t  :,50.00uS,50.00uS\n\nindex,CH1_Voltage(mV),CH2_Voltage(mV)\n"
        + rows(np.arange(COUNT), 1e3 * DRIVE, 1e3 * RESPONSE)
    ),
    "Keysight Infiniium": (
        "Revision:,1\nType:,raw\nStart:,0\nPoints:,400\nXDispRange:,0.02\nXInc:,5.0E-05\nXOrg:,0\nXUnits:,Second\n"
        "YUnits:,Volt\nFrame:,DSOS104A:MY12345678\nDate:,05 MAR 2024\nMax bandwidth:,1e9\nMin bandwidth:,0\nData:,\n"
        + rows(DRIVE, RESPONSE)
    ),
    "Rigol MSO5000": "CH1(V),CH2(V),t0 =0.000000e+00, tInc = 5.000000e-05,\n" + rows(DRIVE, RESPONSE, end=",\n"),
    "Yokogawa": (
        '//YOKOGAWA ASCII FILE FORMAT\n"FormatVersion",1.11\n"BlockNumber",1\n"TraceName","CH1","CH2"\n'
        '"BlockSize",400,400\n"VUnit","V","V"\n"SampleRate",2.0E+04\n"HResolution",5.0E-05,5.0E-05\n'
        '"HOffset",0.0E+00,0.0E+00\n"HUnit","s","s"\n"Date","2024/03/05","2024/03/05"\n"Time","13:05:33.00","13:05:33.00"\n\n'
        + "".join(f",{u:.6E},{z:.6E}\n" for u, z in zip(DRIVE, RESPONSE, strict=True))
    ),
    "Tektronix MDO": (
        "Model,MDO3014\nFirmware Version,1.26\n\nWaveform Type,ANALOG,,\nPoint Format,Y,,\nHorizontal Units,s,,\n"
        "Sample Interval,5e-05,,\nRecord Length,400,,\nGating,0.0% to 100.0%,,\nVertical Units,V,V,\n,,,\n,,,\n"
        "Label,drive,vibrometer,\nTIME,CH1,CH2,\n" + rows(TIME, DRIVE, RESPONSE, end=",\n")
    ),
    "Moku": (
        "% Moku:Go Oscilloscope\r\n% Input 1, DC coupling, 1 MOhm impedance, 10 Vpp range\r\n"
        "% Acquisition rate: 2.0000000000e+04 Hz, Precision mode\r\n% Time (s), Input 1 (V), Input 2 (V)\r\n"
        + rows(TIME, DRIVE, RESPONSE, separator=", ", end="\r\n")
    ),
    "Moku without times": (
        "% Moku:Go Data Logger\n% Acquisition rate: 2.0000000000e+04 Hz, Precision mode\n% Input 1 (V), Input 2 (V)\n"
        + rows(DRIVE, RESPONSE, separator=", ")
    ),
    "PicoScope, French": (
        "Temps;Canal A;Canal B\r\n(ms);(V);(V)\r\n\r\n"
        + rows(1e3 * TIME, DRIVE, RESPONSE, separator=";", end="\r\n", form="{:.8f}").replace(".", ",")
    ),
    "LabVIEW without X": lvm_without_x(),
    "LabVIEW, X for each": lvm_with_x_for_each(),
    "times beside each channel": "Time_0 (s),ai0 (V),Time_1 (s),ai1 (V)\n" + rows(TIME, DRIVE, TIME, RESPONSE),
    "clock": "Timestamp,CH1 (V),CH2 (V)\n" + _stamps(lambda t: f"13:05:{t:09.6f}"),
    "clock of one day and the next": (
        "Timestamp,CH1 (V),CH2 (V)\n"
        + _stamps(lambda t: f"23:59:{t + 26.99:09.6f}" if t < 33.01 else f"00:00:{t - 33.01:09.6f}")
    ),
    "date and clock": "Time,CH1 (V),CH2 (V)\n" + _stamps(lambda t: f"2024-03-05T13:05:{t:09.6f}"),
    "date, clock and half of the day": "Time,CH1 (V),CH2 (V)\n" + _stamps(lambda t: f"03/05/2024 01:05:{t:09.6f} PM"),
    "date in a column of its own": "Date,Time,CH1 (V),CH2 (V)\n" + "".join(
        f"05.03.2024,{line}\n" for line in _stamps(lambda t: f"13:05:{t:09.6f}").splitlines()
    ),
    "means below the table": _TABLE + f"Mean,{DRIVE.mean():.5f},{RESPONSE.mean():.5f}\nStd,2.8,0.35\n",
    "prose below the table": _TABLE + "\nStatistics\nChannel,Min,Max\nCH1,-4,4\nEnd of file\n",
    "Excel": "sep=;\r\nt [ms];CH1 [V];CH2 [V]\r\n"
    + rows(1e3 * TIME, DRIVE, RESPONSE, separator=";", end="\r\n").replace(".", ","),
}  # fmt: skip
"""All of them hold TIME (from any origin), DRIVE and RESPONSE in volts."""


def single(channel: str, kind: str) -> str:
    """One channel alone, as scopes store it, in a file without times or with them."""
    values = DRIVE if channel == "CH1" else RESPONSE
    if kind == "GW Instek":
        head = (
            f"Memory Length,400,\nTrigger Level,-2.4e+01,\nSource,{channel},\nProbe,1.0X,\nVertical Units,V,\n"
            "Vertical Position,1.04e-01,\nHorizontal Units,S,\nHorizontal Mode,Main,\nSampling Period,5.00000e-05,\n"
            "Firmware,V1.09,\nTime, 05-Mar-24 13:05:33,\n"
        )
        return head + "Mode,Detail,\nWaveform Data,\n" + rows(TIME, values, end=",\n")
    if kind == "GW Instek, fast":
        return (
            single(channel, "GW Instek").split("Mode,Detail")[0]
            + "Mode,Fast,\nWaveform Data,\n"
            + rows(values, end=",\n")
        )
    if kind == "Hantek":
        return f"#CHANNEL:{channel}\n#CLOCK=0.000050000S\n#SIZE=400\n#UNITS:V\n\n" + rows(values)
    beside = {0: '"Record Length",400,"Points"', 1: '"Sample Interval",5e-05,"s"', 2: '"Trigger Time",0.01,"s"'}
    lines = [f"{beside.get(k, ',,')},{t:.8e},{v}" for k, (t, v) in enumerate(zip(TIME, values, strict=True))]
    return "\r\n".join(lines) + "\r\n"


SINGLE = ("GW Instek", "GW Instek, fast", "Hantek", "Tektronix TDS, quoted")
