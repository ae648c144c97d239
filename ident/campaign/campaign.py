"""A campaign: the records of one device, and what the user said about them."""

from __future__ import annotations

import copyreg
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from .device import Device, Platform
from .record import Record, Sweep, Trace, common_order
from .said import Said

if TYPE_CHECKING:
    from .quality.suspect import Suspect

MOST_MODES = 6
"""Linear modes that a model may have, its own included."""


def _view(values: dict[str, Any]) -> MappingProxyType[str, Any]:
    return MappingProxyType(values)


# Settings are views that cannot be changed; a campaign, and a fit of it, can be pickled all the same.
copyreg.pickle(MappingProxyType, lambda view: (_view, (dict(view),)))


@dataclass(frozen=True)
class Prior:
    """A Gaussian prior on one parameter, SI."""

    mean: float
    deviation: float


@dataclass(frozen=True, eq=False)
class Campaign:
    """What the lab measured.

    **Arguments:**

    - `effects`: names of the effects to start with; `effect_files`: the user's own effect files.
    - `settings`: per effect, the table `[effect.NAME]` (closure, starting values, `fixed = [...]`), values already SI.
    - `priors`: per full parameter name ("residual-stress.sigma12").
    - `notes`: what was assumed and what the data checks found, one sentence each, to be printed.
    - `checksums`: SHA-256 of every file read.
    - `linear`: the form of the linear model, "auto" if the records decide; `modes`: how many linear modes an oscillator
      has, None if the records decide.
    - `said`: what its file says that decides a result, None if it has none.
    - `files`: what `read_campaign` was given: one TOML file, or data files.
    - `left_out`: traces that were set aside, and why; they are no longer among the `records`.
    """

    title: str
    records: tuple[Record, ...]
    device: Device = field(default_factory=Platform)
    effects: tuple[str, ...] = ()
    effect_files: tuple[Path, ...] = ()
    settings: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    priors: Mapping[str, Prior] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    path: Path | None = None
    checksums: Mapping[str, str] = field(default_factory=dict)
    files: tuple[Path, ...] = ()
    linear: str = "auto"
    modes: int | None = None
    said: Said | None = None
    left_out: tuple[tuple[Trace, Suspect], ...] = ()

    @property
    def traces(self) -> tuple[Trace, ...]:
        return tuple(r for r in self.records if isinstance(r, Trace))

    @property
    def sweeps(self) -> tuple[Sweep, ...]:
        return tuple(r for r in self.records if isinstance(r, Sweep))

    @property
    def fitted(self) -> tuple[Trace, ...]:
        """The traces that the fit may see."""
        return tuple(r for r in self.traces if not r.holdout)

    @property
    def order(self) -> int:
        """Which derivative of the displacement the records are, 0, 1 or 2; 0 where they differ."""
        return common_order(self.records)

    @property
    def heldout(self) -> tuple[Trace, ...]:
        """The traces that only judge."""
        return tuple(r for r in self.traces if r.holdout)

    @property
    def fitted_sweeps(self) -> tuple[Sweep, ...]:
        """The sweeps that the fit may see."""
        return tuple(r for r in self.sweeps if not r.holdout)

    @property
    def shows_settled_motion_only(self) -> bool:
        """Whether all that is fitted are curves read when the motion had settled."""
        return not self.fitted and not any(sweep.fast for sweep in self.fitted_sweeps)

    @property
    def shows_shape(self) -> bool:
        """Whether what is fitted shows the shape of a motion: traces do, and sweeps with their harmonics."""
        return bool(self.fitted) or any(sweep.overtones and not sweep.fast for sweep in self.fitted_sweeps)

    @property
    def heldout_sweeps(self) -> tuple[Sweep, ...]:
        """The sweeps that only judge."""
        return tuple(r for r in self.sweeps if r.holdout)
