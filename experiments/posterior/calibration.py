"""Are the posterior's intervals what they say? Parameters from the prior, records simulated by SciPy, ranks counted.

    python -m experiments.posterior.calibration --cases 60 --results runs/calibration.jsonl

Each case draws frequency, quality, gain and cubic spring of an oscillator from the very priors that are assumed,
simulates two records by an adaptive solver (not by the package), and ranks each truth among draws of the posterior.
`--device platform` draws six parameters of a stressed platform instead (`stressed_platforms`).
`--noise ar` colours the noise; `--starts moving` lets the records begin in motion, so that initial states are
integrated out. `--missing` hides a quadratic damping that the model lacks: no interval may then be called final where
the noise leaves it visible (`--sigma 0.005`, a hundredth of the signal; the standard 0.05 is a tenth of it).
`--by importance` draws by importance sampling instead of the chain that `ident sample` makes.

Source: S. Talts, M. Betancourt, D. Simpson, A. Vehtari, A. Gelman, Validating Bayesian inference algorithms with
simulation-based calibration, arXiv:1804.06788.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy import stats
from scipy.integrate import solve_ivp

from experiments.posterior import stressed_platforms
from experiments.simulator import noise
from experiments.simulator.signals import Tones, multisine
from ident.campaign import Campaign, Channel, NoiseFloor, Oscillator, Trace
from ident.campaign.campaign import Prior
from ident.diagnosis.ranking.missing import missing
from ident.effects.registry import registry
from ident.fit import Fit
from ident.fit.fit import fit
from ident.model import build_model
from ident.posterior.density import Density, make_density
from ident.posterior.evidence import log_evidence
from ident.posterior.misfit import misfit
from ident.posterior.sampler import sample
from ident.report.figures.style import BAND, INK, MODEL, label, new_axes, new_figure, png

PRIORS = {
    "oscillator.frequency": Prior(71.0, 1.5),
    "oscillator.quality": Prior(14.0, 2.0),
    "oscillator.gain": Prior(1.9e5, 2e4),
    "cubic-stiffness.k3": Prior(6e4, 3e4),
}
SIGMA, SAMPLES, DRAWS, RANKS = 0.05, 1000, 399, 20
_STEP = 2.5e-4  # 30 samples per period of the fastest tone: between samples nobody knows the drive


def respond(truth: dict[str, float], drive: Tones, time: np.ndarray, damping: float) -> np.ndarray:
    """z̈ + (ω0/Q) ż + c |ż| ż + ω0² z + k3 z³ = g u from rest, by DOP853."""
    w0 = 2 * np.pi * truth["oscillator.frequency"]
    friction, gain, cubic = w0 / truth["oscillator.quality"], truth["oscillator.gain"], truth["cubic-stiffness.k3"]

    def rate(now: float, state: np.ndarray) -> tuple[float, float]:
        z, v = state
        u = float(drive.value(np.array([now]))[0])
        return v, gain * u - friction * v - damping * abs(v) * v - w0**2 * z - cubic * z**3

    found = solve_ivp(rate, (time[0], time[-1]), (0.0, 0.0), method="DOP853", t_eval=time, rtol=1e-8, atol=1e-11)
    return np.asarray(found.y[0])


def case(seed: int, colour: str, starts: str, hidden: bool, sigma: float) -> tuple[dict[str, float], Fit]:
    """True parameters, and the fit of one simulated campaign."""
    random = np.random.default_rng([14, seed])
    truth = {name: float(random.normal(p.mean, p.deviation)) for name, p in PRIORS.items()}
    lead = 400 if starts == "moving" else 0
    memory = 0.8 if colour == "ar" else 0.0
    records = []
    for k in range(2):
        time = np.arange(SAMPLES + lead) * _STEP
        drive = multisine(0.25, np.arange(20.0, 131.0, 10.0), int(random.integers(1 << 30)))
        clean = respond(truth, drive, time, 0.08 if hidden else 0.0)
        error = noise.autoregressive(random, len(time), sigma, memory)
        floor = NoiseFloor(sigma, (memory,) if memory else (), "given in the campaign")
        volt, start = Channel("V", 1.0), "unknown" if lead else "rest"
        records.append(
            Trace(f"{k}.csv", time[lead:] - time[lead], drive.value(time)[lead:], (clean + error)[lead:], volt, volt,
                  floor, start=start)
        )  # fmt: skip
    campaign = Campaign("calibration", tuple(records), Oscillator(), priors=PRIORS)
    model = build_model(campaign, ("cubic-stiffness",))
    return truth, fit(replace(model, start=tuple((n, p.mean) for n, p in PRIORS.items())), campaign)


def one(seed: int, truth: dict[str, float], found: Fit, by: str) -> dict[str, Any]:
    """Ranks (of `RANKS`) of the truths, whether the intervals hold them, and whether they would be called final."""
    begun = time.process_time()
    density, draws, settled = _drawn(make_density(found), seed, by)
    values = density.values(draws)[:, list(density.static.free)]
    values = values[np.random.default_rng([15, seed]).permutation(len(values))]
    at = np.array([truth[name] for name in density.names])
    below = np.mean(values < at, axis=0)
    return {
        "seed": seed, "names": density.names, "ranks": [int(min(b * RANKS, RANKS - 1)) for b in below],
        "in50": [bool(0.25 < b < 0.75) for b in below], "in90": [bool(0.05 < b < 0.95) for b in below],
        "final": settled and not misfit(density).reasons, "seen": bool(missing(found, registry(()))),
        "cpu": round(time.process_time() - begun, 1),
    }  # fmt: skip


def _drawn(density: Density, seed: int, by: str) -> tuple[Density, np.ndarray, bool]:
    """The density at its peak, draws of it, and whether they have settled: by the chain that a user gets, or by
    importance sampling, which costs a tenth."""
    if by == "importance":
        evidence = log_evidence(density)
        return evidence.density, evidence.resampled(DRAWS, seed), evidence.trusted
    with TemporaryDirectory() as folder:
        sampled = sample(density, Path(folder) / "chain.h5", "calibration", seed=seed)
    return sampled.laplace.density, sampled.draws(DRAWS), not sampled.convergence.reasons


def summary(lines: list[dict[str, Any]]) -> dict[str, Any]:
    """p-value of uniform ranks per parameter, coverage of the intervals, share called final."""
    ranks = np.array([x["ranks"] for x in lines])
    p_values = [float(stats.chisquare(np.bincount(column * 10 // RANKS, minlength=10)).pvalue) for column in ranks.T]
    cover = {name: float(np.mean([x[name] for x in lines])) for name in ("in50", "in90")}
    return {
        "cases": len(lines),
        "p_values": p_values,
        **cover,
        "final": float(np.mean([x["final"] and not x["seen"] for x in lines])),
    }


def check(found: dict[str, Any], hidden: bool, sigma: float) -> None:
    """Ranks are uniform and intervals cover as they say, within what so few cases can show; or none is final;
    under much noise (a tenth of the signal) a few devices show no test that anything is missing."""
    if hidden:
        assert found["final"] <= (0.2 if sigma > 0.01 else 0.0), found
        return
    numbers = found["cases"] * len(found["p_values"])
    assert min(found["p_values"]) * len(found["p_values"]) > 0.01, found
    for name, share in (("in50", 0.5), ("in90", 0.9)):
        assert abs(found[name] - share) < 0.03 + 2.5 * np.sqrt(share * (1 - share) / numbers), found
    assert found["final"] > 0.97, found


def draw(lines: list[dict[str, Any]]) -> Figure:
    """Rank histograms: flat within the band where every interval means what it says."""
    ranks = np.array([x["ranks"] for x in lines]) * 10 // RANKS
    figure = new_figure(11.0, 2.6)
    low, high = stats.binom.ppf([0.005, 0.995], len(lines), 0.1)
    names = lines[0]["names"]
    wide = 0.96 / len(names)
    counts = np.array([np.bincount(ranks[:, k], minlength=10) for k in range(len(names))])
    flat = "flat within chance" if np.all((counts >= low) & (counts <= high)) else "not flat"
    for k, name in enumerate(names):
        axes = new_axes(figure, 0.05 + wide * k, 0.19, 0.8 * wide, 0.6)
        axes.axhspan(low, high, color=BAND)
        axes.bar(np.arange(10), counts[k], width=0.85, color=MODEL)
        axes.axhline(len(lines) / 10, color=INK, lw=0.8, ls=":")
        axes.set_xticks([0, 9], ["low", "high"])
        label(axes, "", "datasets" if k == 0 else "", name.rpartition(".")[2])
    claim = f"Where the truth ranks among draws of its posterior, {len(lines)} datasets: {flat}"
    figure.text(0.008, 0.94, claim, fontsize=11, weight="bold", color=INK, va="center")
    figure.text(
        0.53, 0.03, "rank of the truth among the draws; grey: 99 % of what chance leaves", fontsize=9, ha="center"
    )
    return figure


def main() -> None:
    """Run the study, going on where it stopped."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--device", choices=("oscillator", "platform"), default="oscillator")
    parser.add_argument("--noise", choices=("white", "ar"), default="white")
    parser.add_argument("--starts", choices=("rest", "moving"), default="rest")
    parser.add_argument("--missing", action="store_true")
    parser.add_argument("--by", choices=("chain", "importance"), default="chain")
    parser.add_argument("--sigma", type=float, default=SIGMA)
    parser.add_argument("--results", type=Path, default=Path("runs/calibration.jsonl"))
    parser.add_argument("--figure", type=Path)
    told = parser.parse_args()
    told.results.parent.mkdir(parents=True, exist_ok=True)
    lines = []
    if told.results.exists():
        lines = [json.loads(text) for text in told.results.read_text(encoding="utf-8").splitlines()]
    for seed in range(told.first + len(lines), told.first + told.cases):
        if told.device == "platform":
            drawn = stressed_platforms.case(seed)
        else:
            drawn = case(seed, told.noise, told.starts, told.missing, told.sigma)
        lines.append(one(seed, *drawn, told.by))
        with told.results.open("a", encoding="utf-8") as file:
            file.write(json.dumps(lines[-1]) + "\n")
    found = summary(lines)
    if told.figure is not None:
        told.figure.write_bytes(png(draw(lines)))
    print(json.dumps(found))
    check(found, told.missing, told.sigma)


if __name__ == "__main__":
    main()
