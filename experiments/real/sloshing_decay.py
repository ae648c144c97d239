"""Free decays of a sloshing tank: `python -m experiments.real.sloshing_decay`. IDENT_BENCHMARKS names the folder above
`real/sloshing_decay`.

Its baselines, cubic springs, are of the first 1600 and 500 samples of each decay; they are asked too. What such a
spring can do is asked of plain SciPy too: fitted to the decay that it is judged on, it leaves 6.5 % of the whole, for
below 0.3 mm the liquid begins to stick; of the first 43 s, fitted to the other two, 2.9 %.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.integrate import odeint
from scipy.optimize import least_squares

from experiments import public_data

from .device import Device


def left_by_a_cubic_spring(fitted: Sequence[int], samples: int) -> float:
    """What a cubic oscillator leaves of the first samples of the third decay, per cent; its start and rest are fitted
    there, its own numbers to the given decays."""
    tables = {}
    for k in (1, 2, 3):
        table = np.loadtxt(public_data.data_folder(DEVICE.folder) / f"decay_{k}.csv", delimiter=",", skiprows=1)
        time, response = table[:samples].T
        tables[k] = time - time[0], response

    def left(values: np.ndarray, k: int, start: np.ndarray) -> np.ndarray:
        omega, rate, cubic = values
        time, response = tables[k]
        pull = lambda y, t: (y[1], -rate * y[1] - omega**2 * y[0] - cubic * y[0] ** 3)
        return response - start[2] - odeint(pull, start[:2], time, rtol=1e-8, atol=1e-10)[:, 0]

    def begun(k: int) -> list[float]:
        time, response = tables[k]
        rest = float(np.mean(response[-300:]))
        return [response[0] - rest, float(np.gradient(response, time)[0]), rest]

    def all_left(x: np.ndarray) -> np.ndarray:
        return np.concatenate([left(x[:3], k, x[3 + 3 * i : 6 + 3 * i]) for i, k in enumerate(fitted)])

    guess = np.array([7.816, 0.128, -0.38, *(number for k in fitted for number in begun(k))])
    values = least_squares(all_left, guess, x_scale="jac", diff_step=1e-5).x[:3]
    judged = least_squares(lambda start: left(values, 3, start), begun(3), x_scale="jac", diff_step=1e-5).fun
    return 100 * float(np.std(judged) / np.std(tables[3][1]))


DEVICE = Device(
    "real/sloshing_decay",
    ("decay_1.csv", "decay_2.csv", "decay_3.csv"),
    """device = { kind = "oscillator", output = "m" }

[[record]]
file = "decay_1.csv"

[[record]]
file = "decay_2.csv"

[[record]]
file = "decay_3.csv"
holdout = true
""",
    baseline=35.0,
    start=35.2,
    final=7.0,
    first="cubic-stiffness",
)
EARLY = replace(
    DEVICE, baseline=4.34, start=37.0, final=4.0, first="", rows={file: (0, 1599) for file in DEVICE.files}
)  # 1600 samples, of which the baseline is
# Reached: 0.89, by stiffness-heating alone, so it fails here; an earlier state reached 0.50 with a damping z²ż.
FIRST = replace(EARLY, baseline=0.81, start=18.0, final=0.8, rows={file: (0, 499) for file in DEVICE.files})

if __name__ == "__main__":
    DEVICE.main()
    EARLY.main()
    FIRST.main()
    if public_data.available(DEVICE.folder, DEVICE.files):
        whole, early = left_by_a_cubic_spring((3,), 2400), left_by_a_cubic_spring((1, 2), 1300)
        print(f"plain SciPy, cubic spring: {whole:.2f} % of the decay it is fitted to, {early:.2f} % of its first 43 s")
        assert 6.2 < whole < 6.8, whole
        assert 2.7 < early < 3.1, early
