"""A wing, force to acceleration: `python -m experiments.many_modes`

Four and six linear modes under multisines of three levels, steady answers exact from the frequency response, noise of
0.5 %, given to `ident new` and `ident discover` as three files. Asserted: as many modes as there are, no effect named,
the noise floor reached on fitted and held-out records. And the other way round: oscillators with one of 13 effects, of
3 and 15 %, whose records no further mode predicts to less than 9/10 of what one mode leaves; a second mode, to a tenth.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from experiments.hidden_effects.generator import draw
from experiments.hidden_effects.generator import write as write_case
from ident.campaign import read_campaign
from ident.fit.linear.choice import choose_linear
from ident.fit.linear.modes import find_modes
from ident.fit.linear.stretches import stretch_of

WINGS = {
    "four modes": ((4.9, 0.02, 0.5e-3), (7.3, 0.02, 2e-3), (9.1, 0.015, -1.2e-3), (12.5, 0.015, 0.8e-3)),
    "six modes": ((4.9, 0.02, 0.5e-3), (5.6, 0.01, 0.4e-3), (7.3, 0.02, 2e-3), (9.1, 0.015, -1.2e-3),
                  (11.0, 0.01, 0.3e-3), (12.5, 0.015, 0.8e-3)),
}  # fmt: skip
"""Frequency (Hz), damping ratio, modal gain (1/kg)."""
RATE, SAMPLES, LEVELS, BAND, NOISE = 200.0, 4000, (20.0, 50.0, 80.0), (2.0, 15.0), 0.005
FURTHER = ["second-mode", "third-mode", "fourth-mode", "fifth-mode", "sixth-mode"]


def write(folder: Path, modes: tuple[tuple[float, float, float], ...], seed: int) -> list[Path]:
    """Three files: time (s), force (N), acceleration (m/s²)."""
    rng = np.random.default_rng(seed)
    t, f = np.arange(SAMPLES) / RATE, np.fft.rfftfreq(SAMPLES, 1 / RATE)
    w, paths = 2 * np.pi * f, []
    answer = sum(g * -(w**2) / ((2 * np.pi * fk) ** 2 - w**2 + 4j * np.pi * fk * z * w) for fk, z, g in modes)
    for level in LEVELS:
        lines = np.where((f >= BAND[0]) & (f <= BAND[1]), np.exp(2j * np.pi * rng.uniform(size=f.size)), 0)
        force, read = np.fft.irfft(lines), np.fft.irfft(lines * answer)
        force, read = level * force / np.std(force), level * read / np.std(force)
        read += NOISE * np.std(read) * rng.normal(size=SAMPLES)
        paths.append(folder / f"{level:.0f}N.csv")
        header = "time_s,force_N,acceleration_m_s2"
        np.savetxt(paths[-1], np.c_[t, force, read], delimiter=",", header=header, comments="")
    return paths


EFFECTS = ("cubic-stiffness", "coulomb-friction", "quadratic-damping", "bouc-wen", "sensor-lag", "creep", "end-stop",
           "quadratic-stiffness", "cubic-damping", "viscoelastic-support", "stiffness-drift", "drive-lag",
           "sensor-nonlinearity", "second-mode")  # fmt: skip


def mimics(seed: int = 700) -> dict[tuple[str, float], float]:
    """By effect and its size: what the best further modes leave of records that were left out, over what one leaves."""
    found = {}
    for i, effect in enumerate(EFFECTS):
        for size in (0.03, 0.15):
            case = draw(seed + i, (effect,), size=size, noise=0.003, device="oscillator",
                        starts="mixed" if i % 2 else "rest", records=3 if i % 2 else 6)  # fmt: skip
            with tempfile.TemporaryDirectory() as folder:
                write_case(case, Path(folder, "case"), Path(folder, "truth.json"))
                records = read_campaign(Path(folder, "case")).fitted
            one = choose_linear(records, "oscillator", modes=1).chosen
            tried = find_modes([stretch_of(record) for record in records], (one.first, one.second), one.level)
            found[effect, size] = min(modes.predicted for modes in tried) / tried[0].predicted
    return found


def main() -> None:
    """Run every wing and every effect, and assert what this file claims."""
    for (effect, size), left in mimics().items():
        print(f"{effect} of {size:.0%}: further modes leave {left:.2f} of what one leaves")
        assert left < 0.1 if effect == "second-mode" else left > 0.9, effect
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    for seed, (what, modes) in enumerate(WINGS.items(), 3):
        with tempfile.TemporaryDirectory() as folder:
            call = [sys.executable, "-m", "ident"]
            files = [str(path) for path in write(Path(folder), modes, seed)]
            campaign, run = f"{folder}/wing", f"{folder}/run"
            for command in (["new", campaign, *files], ["discover", campaign, "-o", run]):
                subprocess.run([*call, *command], check=True, capture_output=True, env=environment)
            told = json.loads(Path(run, "run.json").read_text())
            found = json.loads(Path(run, "diagnosis.json").read_text())
        names, errors = told["effects"], [told[use]["error_over_noise"] for use in ("fitted", "holdout")]
        print(f"{what}: {names}, error over noise {errors[0]:.3f}, held out {errors[1]:.3f}, {found['verdict']}")
        assert names == FURTHER[: len(modes) - 1] and max(errors) < 1.1 and found["verdict"] == "adequate"


if __name__ == "__main__":
    main()
