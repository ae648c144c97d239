"""A mass with a disc on a spring, decaying in air: `python -m experiments.real.airdrag_spring`. IDENT_BENCHMARKS names
the folder above `real/airdrag_spring`.

The held-out decay is judged from 30 s on: before, the sensor loses the mass now and then, and what it shows instead
weighs more than any model. Plain SciPy is asked too: drag, and a spring that softens by a power of the displacement.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from experiments import public_data

from .device import Device

STEP = 0.01  # s
SIZE, SPEED = 0.01, 0.1  # m, m/s: units of the initial state
SOFTENS_AT = 0.03  # m, where the power law is counted from
GUESS = np.array([72.4, 0.022, 0.145, -1.2, 0.28])


def motion(law: np.ndarray, begin: np.ndarray, samples: int) -> np.ndarray:
    """Displacement (samples,) under −ω² x − g v − c v |v| − s x |x/x₀|ᵖ; `law`: ω², g, c, s, p, SI per mass."""
    spring, damper, drag, softening, power = map(float, law)

    def pull(x: float, v: float) -> float:
        return -spring * x - damper * v - drag * v * abs(v) - softening * x * abs(x / SOFTENS_AT) ** power

    x, v, h, shown = float(begin[0]), float(begin[1]), STEP, np.empty(samples)
    for k in range(samples):
        shown[k] = x
        a1 = pull(x, v)
        v2 = v + h / 2 * a1
        a2 = pull(x + h / 2 * v, v2)
        v3 = v + h / 2 * a2
        a3 = pull(x + h / 2 * v2, v3)
        v4 = v + h * a3
        a4 = pull(x + h * v3, v4)
        x, v = x + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    return shown


def left_by_drag_and_softening(judged_from: tuple[float, ...]) -> list[float]:
    """What the law, fitted to the first decay, leaves of the other from each of several times on, per cent; the start
    and the rest position are fitted there."""
    fitted, judged = (
        np.loadtxt(public_data.data_folder(DEVICE.folder) / file, delimiter=",", skiprows=1) for file in DEVICE.files
    )

    def begun(response: np.ndarray) -> list[float]:
        rest = float(np.median(response))
        return [(response[0] - rest) / SIZE, float(np.gradient(response, STEP)[2]) / SPEED, rest / SIZE]

    def left(response: np.ndarray, law: np.ndarray, begin: np.ndarray) -> np.ndarray:
        return response - begin[2] * SIZE - motion(law, begin[:2] * [SIZE, SPEED], len(response))

    first = fitted[fitted[:, 0] > 0.5, 1]
    found = least_squares(
        lambda x: left(first, x[:5] * GUESS, x[5:]), [*np.ones(5), *begun(first)], diff_step=1e-6, x_scale="jac"
    )
    shares = []
    for time in judged_from:
        other = judged[judged[:, 0] >= time, 1]
        rest = least_squares(lambda b, other=other: left(other, found.x[:5] * GUESS, b), begun(other), diff_step=1e-6)
        shares.append(100 * float(np.std(rest.fun) / np.std(other)))
    return shares


DEVICE = Device(
    "real/airdrag_spring",
    ("ringdown_1.csv", "ringdown_3.csv"),
    """device = { kind = "oscillator", output = "m" }

[[record]]
file = "ringdown_1.csv"

[[record]]
file = "ringdown_3.csv"
holdout = true
skip = "30 s"
""",
    baseline=3.1,
    start=11.0,
)

if __name__ == "__main__":
    DEVICE.main()
    if public_data.available(DEVICE.folder, DEVICE.files):
        early, late = left_by_drag_and_softening((20.0, 30.0))
        print(f"plain SciPy, drag and softening: {early:.2f} % from 20 s on, {late:.2f} % from 30 s on")
        assert 5.2 < early < 5.6, early
        assert 2.9 < late < 3.3, late
