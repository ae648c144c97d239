"""Effects that have another form: a mode and a part that is carried, dry friction and a contact that bends first."""

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


def belt(seed: int) -> dict:
    """An axis without a spring, of 3 mm and less, whose contact bends by 0.5 mm before it slides, at three quarters of
    what breaks it loose (LuGre, by SciPy): three records from rest, of which one hardly slides and one is held out."""
    rng, t, found = np.random.default_rng(seed), np.arange(2500) / 500.0, []
    stiff, damped, breaks, slides, fall = 900.0, 12.0, 0.43, 0.33, 0.006
    for k, (size, tone) in enumerate(((1.6, 1.3), (1.0, 0.9), (1.3, 1.1))):
        u = lambda t, s=size, f=tone: s * (np.sin(2 * np.pi * f * t) + 0.5 * np.sin(2 * np.pi * 2.7 * f * t + 1.0))

        def rates(t: float, y: np.ndarray, u=u) -> list[float]:
            x, v, bent = y
            level = (slides + (breaks - slides) * np.exp(-((v / fall) ** 2))) / stiff
            slips = v - abs(v) * bent / level
            return [v, 0.45 * float(u(t)) - 4.0 * v - stiff * bent - damped * slips, slips]

        y = solve_ivp(rates, (0, t[-1]), [0.0] * 3, "LSODA", t, rtol=1e-9, atol=1e-12, max_step=2e-3).y[0]
        noisy = y + 0.005 * np.std(y) * rng.standard_normal(len(t))
        table = pd.DataFrame({"t (s)": t, "drive (V)": u(t), "response (mm)": noisy * 1e3})
        found.append({"data": table, "start": "rest", "holdout": k == 2})
    return {"device": {"kind": "oscillator", "output": "mm"}, "record": found}


def test_a_contact_that_bends_before_it_slides_is_found_in_the_place_of_a_friction() -> None:
    found = ident.discover(belt(seed=3))
    assert [step.added for step in found.discovery.steps if step.role == "effect"] == ["presliding-friction"]
    assert found.final.holdout is not None and found.final.holdout.error_over_noise < 1.1
    own = {name: found.final[f"presliding-friction.{name}"] for name in ("friction", "travel", "sliding")}
    true = {"friction": 0.43, "travel": 0.43 / 900.0, "sliding": 0.33 / 0.43}
    for name, number in own.items():
        assert abs(number.value - true[name]) < 4 * number.error + 0.02 * true[name], name
