"""A mode beside the stage's own and a part that the stage carries: the same until a law of the stage bends."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

import ident

HERTZ, PART = 2 * np.pi * 30.0, 2 * np.pi * 47.0


def storeys(bent: float, seed: int) -> dict:
    """Two storeys, the upper a fifth of the lower, which is driven, read, and on a spring that hardens by `bent` of its
    stiffness at 1 mm: three records of band noise, of which one is held out."""
    rng, t = np.random.default_rng(seed), np.arange(3000) / 1500.0
    lines, found = np.arange(12.0, 66.0, 0.7), []
    for k, size in enumerate((1.0, 0.4, 0.8)):
        phases = rng.uniform(0, 2 * np.pi, len(lines))
        u = lambda t, s=size, p=phases: s * np.sum(np.sin(2 * np.pi * lines * np.asarray(t)[..., None] + p), -1)

        def rates(t: float, y: np.ndarray, u=u) -> list[float]:
            x, v, upper, speed = y
            between = 0.2 * (PART**2 * (x - upper) + 0.02 * PART * (v - speed))
            own = -(HERTZ**2) * (x + bent * x**3) - 0.02 * HERTZ * v
            return [v, own - between + 400.0 * float(u(t)), speed, between / 0.2]

        y = solve_ivp(rates, (0, t[-1]), [0.0] * 4, "DOP853", t, rtol=1e-8, atol=1e-9).y[0]
        noisy = y + 0.01 * np.std(y) * rng.standard_normal(len(t))
        table = pd.DataFrame({"t (s)": t, "drive (N)": u(t), "response (mm)": noisy})
        found.append({"data": table, "start": "rest", "holdout": k == 2})
    return {"device": {"kind": "oscillator", "output": "mm", "input": "N"}, "record": found}


@pytest.mark.parametrize(("bent", "names"), [(0.6, {"cubic-stiffness", "attached-mass"}), (0.0, set())])
def test_a_part_that_is_carried_is_named_where_a_spring_bends(bent: float, names: set[str]) -> None:
    found = ident.discover(storeys(bent, seed=5))
    assert {step.added for step in found.discovery.steps if step.role == "effect"} == names
    assert found.verdict in ("identified", "adequate")
    assert found.final.holdout is not None and found.final.holdout.error_over_noise < 1.1
