"""The mass of a platform is a number of its own where records carry different loads, and nowhere else."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.campaign.campaign import Campaign
from ident.campaign.device import Platform
from ident.campaign.read import read_campaign
from ident.campaign.record import Channel, NoiseFloor, Sweep
from ident.errors import UserError
from ident.fit import fit
from ident.model import build_model, linear_part
from ident.report.run_state import state

F, Q, D31, MASS = 500.0, 30.0, 120e-12, 63e-6  # nominal: 60 mg
LOADS = (0.0, 40e-6, 40e-6)


def answer(frequency: np.ndarray, load: float, level: float = 1.0) -> np.ndarray:
    """Complex amplitude of a linear stage of that mass, m."""
    omega, own = 2 * np.pi * frequency, 2 * np.pi * F
    force = D31 * linear_part(Platform()).force_per_gain * level
    return force / (MASS * own**2 - (MASS + load) * omega**2 + 1j * omega * MASS * own / Q)


def campaign(loads: tuple[float, ...] = LOADS, **told: Any) -> Campaign:
    """Steps from rest, solved by SciPy, at as many loads; the last record is held out."""
    time, records = np.arange(2400) / 20e3, []
    force, own = D31 * linear_part(Platform()).force_per_gain, 2 * np.pi * F
    for k, load in enumerate(loads):
        tone = 2 * np.pi * (317.0 + 60 * k)
        slope = lambda t, y, load=load, tone=tone: (
            y[1],
            (force * 5 * np.sin(tone * t) - MASS * own / Q * y[1] - MASS * own**2 * y[0]) / (MASS + load),
        )
        response = solve_ivp(slope, (0, time[-1]), (0, 0), "DOP853", time, rtol=1e-10, atol=1e-16).y[0]
        noise = 0.003 * np.std(response) * np.random.default_rng(k).standard_normal(len(time))
        table: dict[str, Any] = {"time": time, "drive": 5 * np.sin(tone * time), "response": response + noise}
        record = {"data": table, "start": "rest", "holdout": k == len(loads) - 1}
        records.append(record | ({"load": f"{1e6 * load:g} mg"} if load else {}))
    return read_campaign({"record": records, **told})


def test_two_loads_weigh_the_stage_and_its_d31_follows() -> None:
    there = campaign()
    found = fit(build_model(there), there)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.05)
    assert found.holdout is not None and found.holdout.error_over_noise == pytest.approx(1.0, abs=0.08)
    mass = found["mass"]
    assert mass.standard_error is not None and mass.standard_error < 0.003 * MASS
    assert mass.value == pytest.approx(MASS, abs=4 * mass.standard_error)
    assert found["d31"].value == pytest.approx(D31, rel=0.01)
    assert state(found)["weighed"] is True


def test_one_load_tells_nothing_of_the_mass_whichever_it_is() -> None:
    for loads in ((0.0, 0.0, 40e-6), (40e-6, 40e-6, 0.0)):
        assert "platform.mass" not in [p.name for p in build_model(campaign(loads)).parameters]


def test_the_mass_may_be_fixed_where_it_is_weighed_and_named_nowhere_else() -> None:
    fixed: Any = {"effect": {"platform": {"mass": "63 mg", "fixed": ["mass"]}}}
    there = campaign(**fixed)
    (mass,) = [p for p in build_model(there).parameters if p.name == "platform.mass"]
    assert mass.value == pytest.approx(63e-6) and not mass.fitted
    with pytest.raises(UserError, match="mass"):
        build_model(campaign((0.0, 0.0, 0.0), **fixed))


def test_curves_at_two_loads_weigh_it_too() -> None:
    frequency, sweeps = np.linspace(300.0, 560.0, 60), []
    rng, volt, metre = np.random.default_rng(5), Channel("V", 1.0), Channel("m", 1.0)
    for load in (0.0, 40e-6):
        whole = answer(frequency, load)
        sigma = 0.003 * float(np.max(np.abs(whole)))
        whole = whole + sigma * (rng.normal(size=60) + 1j * rng.normal(size=60))
        sweeps.append(Sweep(f"{load}", frequency, np.ones(60), np.abs(whole), np.angle(whole), np.ones(60, bool),
                            "fundamental", volt, metre, NoiseFloor(sigma), load=load))  # fmt: skip
    there = Campaign("curves", tuple(sweeps), Platform())
    found = fit(build_model(there), there)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.15)
    mass = found["mass"]
    assert mass.standard_error is not None and mass.value == pytest.approx(MASS, abs=4 * mass.standard_error)
