"""Speed against the peers, in one process: `python -m experiments.benchmarks.speed`

One record of 4000 samples, 8 V at 317 Hz from rest; residual stress and hysteresis, eight fitted parameters; every side
takes one Runge-Kutta step per sample. Rivals take turns and the fastest of many repeats counts, so that a busy machine
spoils no ratio. Only ratios are asserted, and CPU seconds of a whole `ident fit`.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy: a second thread only spins, for every side alike

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np

from experiments.benchmarks import peers
from experiments.convergence.convergence import STAGE, eight, record, true_values
from ident.fit import fit, solve
from ident.fit.assemble import assemble, begin
from ident.fit.problem import Data, Static, evaluate
from ident.response import Equation, divided, respond, respond_many

ROOT = Path(__file__).resolve().parents[2]
SIGMA = 50e-9
STEPS = 5  # of the adaptive rival, which needs a dozen: its time is a lower bound


class Line(NamedTuple):
    """A row of the table: what was measured, the figure, its unit, and the bound that it must keep."""

    what: str
    figure: float
    unit: str
    bound: float
    at_least: bool = False

    @property
    def kept(self) -> bool:
        return self.figure >= self.bound if self.at_least else self.figure <= self.bound


def fastest(rivals: dict[str, Callable[[], Any]], repeats: int) -> dict[str, float]:
    """Shortest time of each, s; all take a turn in every round, and each is called once before."""
    for call in rivals.values():
        jax.block_until_ready(call())
    best = dict.fromkeys(rivals, np.inf)
    for _ in range(repeats):
        for name, call in rivals.items():
            begun = time.perf_counter()
            jax.block_until_ready(call())
            best[name] = min(best[name], time.perf_counter() - begun)
    return best


class Setting:
    """The one problem, in the form in which each side takes it."""

    def __init__(self) -> None:
        self.model, self.campaign = eight(), record()
        self.truth = true_values(self.model, STAGE)
        self.tape = divided(self.campaign.fitted, [1])
        self.static, self.data = self.assembled(self.truth)
        self.equation = Equation(self.model)
        [lane] = self.tape.lanes
        self.response = self.campaign.fitted[0].response
        self.theta = np.array([getattr(STAGE, name) for name in peers.NAMES])
        self.peer = (lane.voltage, lane.rate, lane.omega, lane.step, 1)

    def assembled(self, start: np.ndarray) -> tuple[Static, Data]:
        """The arrays of a fit that begins at a start."""
        return assemble(self.model, self.campaign, self.campaign.fitted, self.tape, start)

    def starts(self, count: int) -> list[np.ndarray]:
        """Relative moves of the eight parameters: frequency up to ±5 %, the others ±30 %."""
        spread = np.array([0.05] + [0.3] * 7)
        return list(1 + spread * np.random.default_rng(5).uniform(-1, 1, (count, 8)))

    def from_start(self, move: np.ndarray) -> np.ndarray:
        """All parameters of the model (SI) with the fitted ones moved."""
        moved = self.truth.copy()
        moved[list(self.static.free)] *= move
        return moved


def simulations(case: Setting, repeats: int) -> list[Line]:
    """Forward simulation, single and in batches, and the Jacobian."""
    spread = np.random.default_rng(0).normal(1, 0.01, (64, len(case.truth)))
    many, still, out = case.truth * spread, np.zeros((64, 1, 2)), np.empty(len(case.response))
    unknowns = begin(case.data, case.static)
    best = fastest(
        {
            "numba": lambda: peers.simulate(case.theta, *case.peer, out),
            "single": lambda: respond(case.equation, case.tape, case.truth, still[0]).readings,
            "32": lambda: respond_many(case.equation, case.tape, many[:32], still[:32]),
            "64": lambda: respond_many(case.equation, case.tape, many, still),
            "jacobian": lambda: evaluate(case.static, case.data, unknowns),
        },
        repeats,
    )
    for name, seconds in best.items():
        print(f"  {name:10} {seconds * 1e6:9.0f} µs")
    each = min(best["32"] / 32, best["64"] / 64)
    return [
        Line("one of a batch of simulations / numba", each / best["numba"], "", 0.30),
        Line("single simulation / numba", best["single"] / best["numba"], "", 1.8),
        Line("Jacobian by eight parameters / simulation", best["jacobian"] / best["single"], "", 3.0),
    ]


def fits(case: Setting, repeats: int, count: int = 5) -> list[Line]:
    """A whole warm fit against SciPy's `lm` with numba and against SciPy's adaptive solver, from the same starts."""
    moves = case.starts(count)
    minimum = fit(case.model, case.campaign, initial=case.truth)
    ours, numba_, whole = [], [], []
    for move in moves:
        start = case.from_start(move)
        static, data = case.assembled(start)

        def search(static: Any = static, data: Any = data) -> solve.Solution:
            return solve.least_squares(static, data, begin(data, static), solve.How())[1]

        def peer(move: np.ndarray = move) -> Any:
            return peers.fit_numba(case.theta * move, *case.peer, case.response, SIGMA)

        def full(start: np.ndarray = start) -> Any:
            return fit(case.model, case.campaign, initial=start).fitted.error_over_noise

        best = fastest({"search": search, "numba": peer, "fit": full}, repeats)
        ours.append(best["search"])
        numba_.append(best["numba"])
        whole.append(best["fit"])
        error = np.sqrt(search().cost / len(case.response))
        assert error < minimum.fitted.error_over_noise * (1 + 1e-6), error
    begun = time.perf_counter()
    peers.fit_adaptive(case.theta * moves[0], *case.peer, case.response, SIGMA, evaluations=STEPS)
    adaptive = time.perf_counter() - begun
    for name, seconds in (("search", ours), ("numba lm", numba_), ("fit", whole)):
        print(f"  {name:10} " + " ".join(f"{s * 1e3:8.1f}" for s in seconds) + " ms")
    print(f"  solve_ivp  {adaptive * 1e3:8.0f} ms for the first {STEPS} steps")
    return [
        Line("SciPy lm with numba / warm search", float(np.median(numba_) / np.median(ours)), "", 1.0, True),
        Line("SciPy solve_ivp least_squares / warm fit", adaptive / whole[0], "", 100.0, True),
    ]


def command(repeats: int) -> list[Line]:
    """CPU seconds of `ident fit data/platform_317hz`, with an empty cache folder and with a filled one."""
    cold, warm = [], []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as folder:
            cold.append(_cpu_seconds(Path(folder)))
            warm.append(_cpu_seconds(Path(folder)))
    return [
        Line("`ident fit`, first time ever, CPU", min(cold), "s", 6.0),
        Line("`ident fit`, later, CPU", min(warm), "s", 4.0),
    ]


def _cpu_seconds(folder: Path) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    call = [sys.executable, "-m", "ident.cli.main", "fit", str(ROOT / "data" / "platform_317hz")]
    environment = os.environ | {"IDENT_CACHE": str(folder / "cache")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # a user's Python keeps the bytecode of what it has imported
    done = subprocess.run(
        [*call, "-o", str(folder / "run"), "--force"], env=environment, cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Run the comparison from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=200)
    options = parser.parse_args()
    case = Setting()
    lines = simulations(case, options.repeats) + fits(case, max(3, options.repeats // 40)) + command(2)
    for line in lines:
        sign, mark = ("≥" if line.at_least else "≤"), "" if line.kept else "   missed"
        print(f"{line.what:45} {line.figure:8.2f} {line.unit:2} {sign} {line.bound:g}{mark}")
    assert all(line.kept for line in lines), [line for line in lines if not line.kept]


if __name__ == "__main__":
    main()
