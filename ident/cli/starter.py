"""The starter campaign of `ident new`: two records simulated by our own model, and the effect file behind them."""

from __future__ import annotations

from pathlib import Path

CAMPAIGN = """\
# A campaign: what was measured with one device. Replace the tables by your own and change what differs.
#     ident check {folder}        what the data are worth
#     ident fit {folder}          least squares and a report
title = "starter campaign"
# device = "device.toml"           # geometry and materials; without it, the nominal platform
# device = {{ kind = "oscillator", output = "V" }}     # or any driven oscillator, in the unit of its response

[model]
# Where to start: names from `ident effects`, or from your own files; [] is the plain linear platform.
# Try `ident fit {folder} --effects ""` to see what the records look like without the effect of my_effect.py.
effects = ["gas-drag"]
effect_files = ["my_effect.py"]

# [effect.gas-drag]                # settings and starting values of one effect
# c = "1e-3 N*s^2/m^2"
# fixed = ["c"]                    # parameters that a fit must not move

# [priors]                         # mean and standard deviation
# "platform.quality" = {{ normal = [35, 5] }}

[[record]]
file = "sine_8V_500Hz.csv"         # its column names carry the units
kind = "trace"                     # time, drive voltage, displacement
start = "rest"                     # "rest" | "steady" | "unknown": then the initial state is fitted
# noise = "20 nm"                  # otherwise estimated
# skip = "5 ms"                    # leading part that is simulated but not counted
# load = "40 mg"                   # extra mass on the stage

[[record]]
file = "sine_5V_480Hz.csv"
kind = "trace"
start = "rest"
holdout = true                     # never fitted, only used to judge
"""

EFFECT = '''\
"""An effect of your own: drag of the gas around the stage. docs/add-an-effect.md tells the rest."""

import jax.numpy as jnp

from ident.effects import AbstractEffect, amplitude


class GasDrag(AbstractEffect):
    """Drag of the surrounding gas: force −c |v| v."""

    name = "gas-drag"
    equation = "F = −c |v| v"
    mistaken_for = ("quadratic-damping",)
    c = amplitude("N*s^2/m^2", "drag coefficient", positive=True, default=1e-3)  # zero means: no such effect

    def force(self, state, drive, t):
        return -self.c * jnp.abs(state.v) * state.v
'''

_RECORDS = {"sine_8V_500Hz.csv": (8.0, 500.0), "sine_5V_480Hz.csv": (5.0, 480.0)}
_RATE, _SAMPLES, _NOISE = 40e3, 1600, 20e-9
_TRUTH = {"platform.quality": 35.0, "platform.d31": 30e-12, "gas-drag.c": 4e-3}


def write_starter(folder: Path) -> tuple[Path, ...]:
    """Write the starter campaign into a folder, and return the files."""
    from ..campaign.trust import trust

    tables = _tables()
    folder.mkdir(parents=True, exist_ok=True)
    files = {"campaign.toml": CAMPAIGN.format(folder=folder.as_posix()), "my_effect.py": EFFECT, **tables}
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    trust(folder / "my_effect.py")  # our own words
    return tuple(folder / name for name in files)


def _tables() -> dict[str, str]:
    import tempfile

    import numpy as np

    from ..campaign import Channel, NoiseFloor, Platform, Trace
    from ..campaign.trust import trust
    from ..effects.registry import registry
    from ..fit.reading import read
    from ..model import Model

    with tempfile.TemporaryDirectory() as folder:  # the file that the user gets is the one that makes the records
        file = Path(folder) / "my_effect.py"
        file.write_text(EFFECT, encoding="utf-8")
        trust(file)
        model = Model(Platform(), (registry([file])["gas-drag"](),))
    values = np.array([_TRUTH.get(p.name, p.value) for p in model.parameters])
    time = np.arange(_SAMPLES) / _RATE
    records = [
        Trace(name, time, level * np.sin(2 * np.pi * frequency * time), np.zeros(_SAMPLES), Channel("V", 1.0),
              Channel("um", 1e-6), NoiseFloor(_NOISE), start="rest")
        for name, (level, frequency) in _RECORDS.items()
    ]  # fmt: skip
    random = np.random.default_rng(1)
    tables = {}
    for record, reading in zip(records, read(model, values, records), strict=True):
        measured = 1e6 * (reading + random.normal(0.0, _NOISE, _SAMPLES))
        rows = [f"{t:.6f},{v:.4f},{z:.4f}" for t, v, z in zip(time, record.drive, measured, strict=True)]
        tables[record.name] = "\n".join(["time (s),drive (V),displacement (um)", *rows]) + "\n"
    return tables
