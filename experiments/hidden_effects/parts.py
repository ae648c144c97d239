"""The parts of the study: which cases each has, and what is written down about one."""

from __future__ import annotations

import itertools
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from experiments.simulator.signals import Played
from ident.diagnosis.diagnose import discover, measure_next
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.search.beyond import go_beyond
from ident.diagnosis.search.steps import Discovery
from ident.diagnosis.unknown.find import find_unknown
from ident.effects.registry import built_in
from ident.fit import Fit

from .campaigns import campaign_of, poor_case, rounded, sigma_ratios
from .circumstances import CIRCUMSTANCES, can_show
from .generator import Case, NoiseKind, Starts, draw, measure_again
from .laws import INDEX, LAWS
from .mimics import left_by

Part = Literal["single", "pairs", "nulls", "outside", "poor", "cut", "steady", "circumstances", "long"]

INSIDE = tuple(law.name for law in LAWS if law.in_library)
OUTSIDE = tuple(law.name for law in LAWS if not law.in_library)
# Size 0.5 % under noise of 1 % is left out: such an effect is below the noise.
LEVELS = ((0.02, 0.001), (0.02, 0.01), (0.08, 0.001), (0.08, 0.01), (0.005, 0.001))
OUTSIDE_LEVELS = ((0.02, 0.003), (0.08, 0.01))
MEMORIES = ("viscoelastic-support", "creep", "bouc-wen", "prandtl-ishlinskii", "bouc-wen-drive", "second-mode",
            "drive-lag", "sensor-lag")  # fmt: skip
NULL_NOISE = (0.001, 0.003, 0.01, 0.03)
NULL_KINDS: tuple[NoiseKind, ...] = ("white", "ar", "hum")
_FINER = 20  # steps of the played waveform per sample
STRESSED = {"residual-stress", "arch-force"}


@dataclass(frozen=True)
class Task:
    """One case to draw; what `generator.draw` is told."""

    part: Part
    seed: int
    effects: tuple[str, ...]
    size: float
    noise: float
    noise_kind: NoiseKind = "white"
    starts: Starts = "rest"
    circumstance: str = ""

    @property
    def key(self) -> str:
        """What tells the cases of a file of results apart."""
        return "/".join(str(value) for value in asdict(self).values())

    def draw(self) -> Case:
        """The case."""
        if self.part == "poor":
            return poor_case(self.seed, self.effects, self.size, self.noise)
        if self.circumstance:
            return CIRCUMSTANCES[self.circumstance](self.seed, self.effects, size=self.size, noise=self.noise)
        return draw(self.seed, self.effects, size=self.size, noise=self.noise, noise_kind=self.noise_kind,
                    starts=self.starts)  # fmt: skip


def tasks(
    part: Part, seeds: Sequence[int], effects: Sequence[str] | None, levels: Sequence[tuple[float, float]] | None
) -> list[Task]:
    """The cases of a part. Effects and levels, (size, noise), replace those of the part."""
    return list(_MAKERS[part](seeds, effects, levels))


def _single(seeds: Sequence[int], effects: Any, levels: Any) -> Iterator[Task]:
    for seed, (size, noise), name in itertools.product(seeds, levels or LEVELS, effects or INSIDE):
        yield Task("single", seed, (name,), size, noise)


def _pairs(seeds: Sequence[int], effects: Any, levels: Any) -> Iterator[Task]:
    """One pair per seed, drawn among the effects that are not alike."""
    alike = {law.name: set(law.alike) | {law.name} for law in LAWS}
    for seed, (size, noise) in itertools.product(seeds, levels or ((0.02, 0.003),)):
        rng = np.random.default_rng([seed, 11])
        first, second = INSIDE[0], INSIDE[0]
        while second in alike[first] or {first, second} == STRESSED:
            first, second = (INSIDE[i] for i in sorted(rng.choice(len(INSIDE), 2, replace=False)))
        yield Task("pairs", seed, tuple(effects or (first, second)), size, noise)


def _nulls(seeds: Sequence[int], effects: Any, levels: Any) -> Iterator[Task]:
    """Nothing hidden; colour, strength of the noise and starts take turns."""
    for seed in seeds:
        noise = NULL_NOISE[seed // len(NULL_KINDS) % len(NULL_NOISE)]
        mixed = seed // (len(NULL_KINDS) * len(NULL_NOISE)) % 2
        starts = "mixed" if mixed else "rest"
        yield Task("nulls", seed, (), 0.02, noise, NULL_KINDS[seed % len(NULL_KINDS)], starts)


def _outside(seeds: Sequence[int], effects: Any, levels: Any) -> Iterator[Task]:
    for seed, (size, noise), name in itertools.product(seeds, levels or OUTSIDE_LEVELS, effects or OUTSIDE):
        yield Task("outside", seed, (name,), size, noise)


def _poor(seeds: Sequence[int], effects: Any, levels: Any) -> Iterator[Task]:
    for seed, (size, noise), name in itertools.product(seeds, levels or ((0.08, 0.003),), effects or INSIDE):
        yield Task("poor", seed, (name,), size, noise)


def _cut(seeds: Sequence[int], effects: Any, levels: Any) -> Iterator[Task]:
    """Effects with memory, half of the records cut out of a running motion."""
    for seed, (size, noise), name in itertools.product(seeds, levels or ((0.02, 0.003),), effects or MEMORIES):
        yield Task("cut", seed, (name,), size, noise, starts="mixed")


def _steady(seeds: Sequence[int], effects: Any, levels: Any) -> Iterator[Task]:
    """Effects that stand still, and none, in records of which the switching-on has died away."""
    still = [name for name in INSIDE if "t" not in LAWS[INDEX[name]].coordinates]
    for seed, (size, noise), name in itertools.product(seeds, levels or ((0.02, 0.003),), effects or [*still, ""]):
        yield Task("steady", seed, (name,) if name else (), size, noise, starts="steady")


def _circumstances(seeds: Sequence[int], effects: Any, levels: Any) -> Iterator[Task]:
    """Every circumstance with as many effects as there are seeds, drawn among those that exist there."""
    for seed, (size, noise), where in itertools.product(seeds, levels or ((0.04, 0.003),), CIRCUMSTANCES):
        there = [name for name in effects or INSIDE if can_show(where, name)]
        name = there[int(np.random.default_rng([seed, 29, len(where)]).integers(len(there)))]
        yield Task("circumstances", seed, (name,), size, noise, circumstance=where)


def _long(seeds: Sequence[int], effects: Any, levels: Any) -> Iterator[Task]:
    """Every effect that an oscillator can show in long records."""
    for seed, (size, noise), name in itertools.product(seeds, levels or ((0.04, 0.003),), effects or INSIDE):
        if can_show("long_records", name):
            yield Task("long", seed, (name,), size, noise, circumstance="long_records")


_MAKERS: dict[Part, Callable[..., Iterator[Task]]] = {
    "single": _single, "pairs": _pairs, "nulls": _nulls, "outside": _outside, "poor": _poor,
    "cut": _cut, "steady": _steady, "circumstances": _circumstances, "long": _long,
}  # fmt: skip


def run(task: Task) -> dict[str, Any]:
    """Draw a case, let the tool discover as a user would, who gets what the library lacks as a file, and write down
    what it said beside what is true."""
    with tempfile.TemporaryDirectory() as folder:
        return _said(task, Path(folder) / "effect.py")


def _said(task: Task, effect_file: Path) -> dict[str, Any]:
    case = task.draw()
    campaign = campaign_of(case)
    began = time.process_time(), time.perf_counter()
    said = discover(campaign, effect_file=effect_file)
    found = said.discovery
    spent = time.process_time() - began[0], time.perf_counter() - began[1]
    row: dict[str, Any] = {
        "key": task.key,
        **asdict(task),
        "true_size": case.truth["size"],
        "laws": case.truth["laws"],
        "verdict": found.verdict,
        "suspects": [f"{one.file} {one.kind}" for one in said.suspects],
        "steps": [
            {"added": s.added, "role": s.role, "predicted": round(s.predicted_gain, 5),
             "confirmed": round(s.confirmed_gain, 5), "ties": list(s.tie_set[1:]),
             "error": round(s.fit.fitted.error_over_noise, 4)}
            for s in found.steps
        ],
        "ranking": [[c.name, round(c.predicted_gain, 5), c.p_value] for c in found.ranking[:6]],
        "confirmed": {name: round(gain, 5) for name, gain in found.confirmed.items()},
        "remaining": [[c.name, round(c.predicted_gain, 5), c.p_value] for c in found.remaining[:3]],
        "before": _errors(found.start),
        "after": _errors(found.final),
        "lacking": round(found.lacking, 5),
        "converged": found.final.converged,
        "sigma_ratio": rounded(sigma_ratios(case, campaign)),
        "cpu_seconds": round(spent[0], 1),
        "seconds": round(spent[1], 1),
    }  # fmt: skip
    if task.part == "outside":
        row["unknown"] = _unknown(found)
        names = [s.added for s in found.steps]
        if found.verdict == "identified" and set(names) <= INDEX.keys():  # others the study cannot simulate
            row["unknown"]["left_by_name"] = round(left_by(case, names), 1)
    if task.part == "poor":
        row["next"] = _measured_next(case, found)
    return row


def _measured_next(case: Case, found: Discovery) -> dict[str, Any] | None:
    """What is said once the record that the tool proposes has been taken; None if nothing ties."""
    if not any(s.role == "effect" and len(s.tie_set) > 1 for s in found.steps):
        return None
    proposed = measure_next(found, built_in())
    if not proposed:
        return {"record": None, "named": [], "expected": 0.0}
    best = proposed[0]
    fine = np.linspace(best.time[0], best.time[-1], _FINER * (len(best.time) - 1) + 1)
    taken = measure_again(case, "next", Played(fine, best.waveform.voltage(fine)), best.time)
    campaign = campaign_of(replace(case, records=[*case.records, taken]))
    after = discover(campaign).discovery
    names = [name for s in after.steps if s.role == "effect" for name in s.tie_set]
    return {"record": best.record, "named": names, "expected": round(best.expected_delta_chi2, 1)}


def _errors(fitted: Fit) -> list[float | None]:
    """Error over noise on the fitted and on the held-out records."""
    held = fitted.holdout
    return [round(fitted.fitted.error_over_noise, 4), None if held is None else round(held.error_over_noise, 4)]


def _unknown(found: Discovery) -> dict[str, Any]:
    """What is said of the missing term before any effect was added, and the errors once it is written and refitted."""
    with tempfile.TemporaryDirectory() as folder:
        regression = prepare(found.start)
        beyond = go_beyond(found.start, regression, find_unknown(regression), Path(folder) / "unknown.py")
    unknown = beyond.unknown
    formula = unknown.formula.text if unknown.formula is not None else ""
    alike = [[r.side, list(r.coordinates)] for r in unknown.alike]
    return {"side": unknown.side, "coordinates": list(unknown.coordinates), "alike": alike, "share": unknown.share,
            "formula": formula, "explained": unknown.explained(unknown.formula),
            "written": _errors(beyond.fit)}  # fmt: skip
