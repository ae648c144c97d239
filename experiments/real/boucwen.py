"""The hysteretic benchmark of Noël and Schoukens: `python -m experiments.real.boucwen`. IDENT_BENCHMARKS names the
folder above `real/boucwen`.

The sweep is judged too. How its drive ran between the samples is not said, and it matters more than the fit: the law
that was published with it, with its own numbers, integrated by SciPy, leaves 0.27 % of it where the drive is a smooth
curve through its samples, and 0.10 % where it is straight between them (of the multisine 0.04 and 1.2 %).
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

from experiments import public_data

from .device import Device

SAMPLES = 2000  # of the sweep, enough to forget its start
FORGOTTEN = 500


def left_by_the_law(degree: int) -> float:
    """What the published law leaves of the sweep, per cent of the signal; the drive a spline of a `degree`."""
    table = np.loadtxt(public_data.data_folder(DEVICE.folder) / "test_sweep.csv", delimiter=",", skiprows=1)
    step, (drive, response) = 1 / 750, table[:SAMPLES, 1:].T
    time = step * np.arange(SAMPLES)
    force = make_interp_spline(time, drive, degree)

    def rates(t: float, state: np.ndarray) -> list[float]:
        y, v, z = state
        return [v, (force(t) - 10 * v - 5e4 * y - z) / 2, 5e4 * v - 1e3 * (0.8 * abs(v) * z - 1.1 * v * abs(z))]

    begin = [response[0], (response[1] - response[0]) / step, 0.0]
    found = solve_ivp(rates, (0.0, time[-1]), begin, t_eval=time, max_step=step, rtol=1e-8, atol=[1e-12, 1e-10, 1e-8])
    left = (response - found.y[0])[FORGOTTEN:]
    return 100 * float(np.std(left) / np.std(response[FORGOTTEN:]))


DEVICE = Device(
    "real/boucwen",
    ("train_multisine.csv", "test_multisine.csv", "test_sweep.csv"),
    """device = { kind = "oscillator", output = "m", input = "N" }

[[record]]
file = "train_multisine.csv"
skip = 200

[[record]]
file = "test_multisine.csv"
holdout = true
skip = 200

[[record]]
file = "test_sweep.csv"
holdout = true
skip = 200
""",
    baseline=0.03,
    start=27.0,
    final=0.3,
    records={"test_multisine.csv": 0.05, "test_sweep.csv": 0.3},
    verdicts=frozenset({"identified", "ambiguous"}),
    first="bouc-wen",
    never=frozenset({"cubic-stiffness", "viscoelastic-support", "coulomb-friction", "creep"}),
)

if __name__ == "__main__":
    DEVICE.main()
    if public_data.available(DEVICE.folder, DEVICE.files):
        smooth, straight = left_by_the_law(3), left_by_the_law(1)
        print(f"of the sweep the published law leaves {smooth:.3f} % (drive smooth), {straight:.3f} % (drive straight)")
        assert 0.25 < smooth < 0.30, smooth
        assert 0.08 < straight < 0.12, straight
