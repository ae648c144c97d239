"""Which of two columns is the drive, where no name tells: the one that switches, or has less noise for its size.

One file may mislead, as where the drive is weak; an instrument, however, writes the same channel into the same column.
So files whose columns have the same names are decided together, and one that says otherwise is told.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .period import noise_between

Roles = Mapping[str, str | int]

_MOST = math.log(20.0)  # of one file's say: a channel without noise is smoother by any factor
_TIE = 0.1  # of all that is said: closer than that, the files contradict one another


@dataclass(frozen=True)
class Chosen:
    """The columns of one file by their roles, and how it was decided which is the drive: `open` if no name told,
    `smoother`, by how much it is (the logarithm of a ratio), `switches`, if it does and the response does not."""

    columns: Roles
    open: bool = False
    smoother: float = 0.0
    switches: bool = False

    @property
    def doubt(self) -> str:
        """What is not known of these columns."""
        by = "the one that switches" if self.switches else "the smoother"
        return f"{_question(self)}; {by} is taken" if self.open else ""

    @property
    def pair(self) -> frozenset[str | int]:
        """The two columns between which was decided."""
        return frozenset((self.columns["drive"], self.columns["response"]))


def decided_together(chosen: Mapping[Path, Chosen]) -> dict[Path, tuple[Roles, str]]:
    """The columns of every file and its doubt; files with the same two columns to choose from have the same drive."""
    found = {path: (one.columns, one.doubt) for path, one in chosen.items()}
    for pair in dict.fromkeys(one.pair for one in chosen.values() if one.open):
        alike = {path: one for path, one in chosen.items() if one.open and one.pair == pair}
        if len({one.columns["drive"] for one in alike.values()}) > 1:
            found |= _agreed(alike)
    return found


def _agreed(alike: Mapping[Path, Chosen]) -> dict[Path, tuple[Roles, str]]:
    """One pair of columns for files that each say another one: what speaks for each is summed over them."""
    sized = not any(one.switches for one in alike.values())  # whoever switches is the drive, by how much or not
    says = {path: min(one.smoother, _MOST) if sized else float(one.switches) for path, one in alike.items()}
    names = list(dict.fromkeys(one.columns["drive"] for one in alike.values()))
    of = {name: [path for path, one in alike.items() if one.columns["drive"] == name] for name in names}
    total = {name: math.fsum(says[path] for path in paths) for name, paths in of.items()}
    usual = max(names, key=lambda name: (total[name], len(of[name])))
    torn = abs(total[names[0]] - total[names[1]]) <= _TIE * math.fsum(total.values())
    if torn and len(of[names[0]]) != len(of[names[1]]):
        usual = max(names, key=lambda name: len(of[name]))
    found = {}
    for path, one in alike.items():
        own = one.columns["drive"]
        agreed = one if own == usual else replace(one, columns=_turned(one.columns))
        if torn:
            split = " and ".join(f'"{name}" in {", ".join(p.name for p in of[name])}' for name in names)
            doubt = f'{_question(one)}, and the files contradict one another ({split}); "{usual}" is taken in all'
        elif own == usual:
            doubt = one.doubt
        else:
            by = "switches" if one.switches else "is the smoother"
            doubt = (
                f'{_question(one)}; "{usual}" is taken, which it is by all files together, but here "{own}" {by}: '
                "were the channels exchanged?"
            )
        found[path] = agreed.columns, doubt
    return found


def _question(one: Chosen) -> str:
    first, second = sorted((one.columns["drive"], one.columns["response"]), key=str)
    return f'which of "{first}" and "{second}" is the drive is not said'


def _turned(columns: Roles) -> Roles:
    return {**columns, "drive": columns["response"], "response": columns["drive"]}


def by_how_much(drive: np.ndarray, response: np.ndarray) -> float:
    """By how much a drive (n,) is smoother than a response (n,): the logarithm of the ratio of noise over size."""
    return math.log(max(roughness(response), 1e-300) / max(roughness(drive), 1e-300))


def switches(values: np.ndarray) -> bool:
    """Whether a signal has two levels, and hardly anything between, as a generator or a trigger has: a sine spends 29 %
    of its time within a twentieth of its range from its ends."""
    values = values[np.isfinite(values)]
    low, high = np.quantile(values, (0.01, 0.99))
    near = np.minimum(np.abs(values - low), np.abs(values - high)) < 0.05 * (high - low)
    return bool(np.mean(near) > 0.9)


def roughness(values: np.ndarray) -> float:
    """Noise over size."""
    values = values[np.isfinite(values)]
    return float(np.sqrt(noise_between(values)) / max(float(np.std(values)), 1e-300))
