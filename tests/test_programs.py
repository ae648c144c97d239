"""Programs are compiled once, for any number and length of records, and kept between processes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ident import programs
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.effects.registry import built_in, registry
from ident.fit import fit
from ident.fit.reading import read
from ident.model import Model

TESTS = Path(__file__).resolve().parent.parent


def noisy(samples: int, hertz: float, seed: int, step: float = 1e-3, k3: float = 40.0) -> Trace:
    """A record of a Duffing oscillator at 10 Hz, by semi-implicit Euler steps of a hundredth of a sample."""
    t = step * np.arange(samples)
    drive, z, v, out = np.sin(2 * np.pi * hertz * t), 0.0, 0.0, []
    h, omega = step / 100, 2 * np.pi * 10.0
    for u in drive:
        out.append(z)
        for _ in range(100):
            v += h * (1000.0 * u - omega / 20.0 * v - omega**2 * z - k3 * z**3)
            z += h * v
    response = np.array(out) + 1e-3 * np.random.default_rng(seed).standard_normal(samples)
    volts = Channel("V", 1.0)
    return Trace(f"{seed}.csv", t, drive, response, volts, volts, NoiseFloor(1e-3, method="given"), "rest")


def counted() -> int:
    return programs.COUNTS["traced"] + programs.COUNTS["loaded"]


def test_other_records_need_no_other_program():
    from ident.campaign.campaign import Campaign

    model = Model(Oscillator(), (built_in()["cubic-stiffness"](Oscillator()),))
    few = Campaign("few", (noisy(300, 8.0, 1), noisy(420, 11.0, 2)), Oscillator())
    many = Campaign(
        "many", tuple(noisy(n, 9.0 + i, 3 + i, 5e-4) for i, n in enumerate((200, 977, 350, 801))), Oscillator()
    )
    fit(model, few)
    before = counted()
    fit(model, many)
    assert counted() == before


def test_records_that_cross_a_chunk_are_marched_through_as_one():
    # One record of several chunks against SciPy; beside short ones, so that it begins in the middle of a chunk.
    from scipy.integrate import solve_ivp

    samples, step = 20_000, 1e-3
    t = step * np.arange(samples)
    volts = Channel("V", 1.0)
    told = (volts, volts, NoiseFloor(1e-9), "rest")
    long = Trace("long.csv", t, np.sin(2 * np.pi * 7.0 * t), 0.0 * t, *told)  # type: ignore[arg-type]
    short = Trace("short.csv", t[:333], np.sin(2 * np.pi * 3.0 * t[:333]), 0.0 * t[:333], *told)  # type: ignore[arg-type]
    model = Model(Oscillator(), (built_in()["cubic-stiffness"](Oscillator()),))
    values = np.array([10.0, 50.0, 2000.0, 300.0, 0.0])
    found = read(model, values, [short, long, short])[1]
    omega = 2 * np.pi * 10.0
    rates = lambda t, y: (y[1], 2000.0 * np.sin(2 * np.pi * 7.0 * t) - omega / 50.0 * y[1] - omega**2 * y[0]
                          - 300.0 * y[0] ** 3)  # fmt: skip
    exact = solve_ivp(rates, (0, t[-1]), (0, 0), "DOP853", t, rtol=1e-11, atol=1e-13).y[0]
    assert np.max(np.abs(found - exact)) < 1e-5 * np.max(np.abs(exact))


SCRIPT = """
import sys
from ident import programs
from ident.fit.reading import read
from ident.model import Model
from ident.campaign.device import Platform
from ident.effects.registry import built_in
from tests.test_programs import noisy
# Forces of the frame call LAPACK, which code that is only loaded must find too.
effect = built_in()["residual-stress"](Platform(), {"closure": "frame"})
model = Model(Platform(), (effect,))
values = [p.value * 1.0 for p in model.parameters]
values[:5] = [10.0, 20.0, 1e-9, 80e6, 45e6]
import numpy as np
print(float(np.sum(read(model, np.array(values), [noisy(int(sys.argv[1]), 8.0, 1)])[0])))
print(programs.COUNTS["traced"], programs.COUNTS["loaded"])
"""


def process(cache: Path | str, samples: int) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(samples)],
        capture_output=True, text=True, cwd=TESTS, env=os.environ | {"IDENT_CACHE": str(cache)}, check=True,
    )  # fmt: skip
    return done.stdout.split("\n")


def test_a_second_process_traces_nothing_and_says_the_same(tmp_path):
    first, second = process(tmp_path, 200), process(tmp_path, 200)
    assert first[1] == "1 0" and second[1] == "0 1"
    assert first[0] == second[0]
    assert process(tmp_path, 310)[1] == "0 1"


def test_a_damaged_program_is_compiled_again(tmp_path):
    first = process(tmp_path, 200)
    for file in tmp_path.rglob("*.xla"):
        file.write_bytes(file.read_bytes()[:1000])
    again = process(tmp_path, 200)
    assert again[0] == first[0] and again[1] == "1 0"


def test_without_a_cache_nothing_is_written(tmp_path):
    assert process("off", 200)[1] == "1 0"
    assert not list(tmp_path.iterdir())


EFFECT = """
from ident.effects import AbstractEffect, amplitude
class Stiffer(AbstractEffect):
    \"\"\"Restoring force k z^{power}.\"\"\"
    name = "stiffer"
    k = amplitude("N/m")
    def force(self, state, drive, t):
        return -self.k * state.z * {factor}
"""


def test_an_effect_file_is_told_by_its_text(tmp_path):
    file = tmp_path / "mine.py"
    prints = []
    for factor in ("1.0", "2.0"):
        file.write_text(EFFECT.format(power=1, factor=factor), encoding="utf-8")
        prints.append(registry([file])["stiffer"](Oscillator()).fingerprint)
    assert None not in prints and prints[0] != prints[1]


def test_an_effect_without_a_file_is_not_kept():
    namespace: dict[str, object] = {}
    exec(EFFECT.format(power=1, factor="1.0"), namespace)
    effect = namespace["Stiffer"]
    assert effect(Oscillator()).fingerprint is None  # type: ignore[operator]


@pytest.mark.parametrize("directions", [3, 7, 12, 13, 30])
def test_any_number_of_directions_gives_the_same_slopes(directions):
    from ident.response import Equation, lay_out, respond

    model = Model(Oscillator())
    tape = lay_out([noisy(200, 8.0, 1)], 10.0, 20.0, model)
    values, still = np.array([10.0, 20.0, 1000.0]), np.zeros((directions, 1, 2))
    along = np.random.default_rng(0).normal(size=(directions, 3)) * values
    found = respond(Equation(model), tape, values, np.zeros((1, 2)), along, still)
    single = respond(Equation(model), tape, values, np.zeros((1, 2)), np.diag(values), np.zeros((3, 1, 2)))
    assert found.slopes.shape == (directions, 200)
    np.testing.assert_allclose(found.slopes, along / values @ single.slopes, atol=1e-9 * np.max(np.abs(single.slopes)))


def test_programs_that_were_not_used_for_long_are_let_go(monkeypatch):
    held, obtained = programs._Held(), []
    monkeypatch.setattr(programs, "_MOST", 2)

    def get(key: str) -> None:
        held.get(key, lambda: obtained.append(key) or (lambda *_: key))

    for key in "aabacab":
        get(key)
    assert obtained == ["a", "b", "c", "b"]  # b was the one that had not been used for longest when c came
