"""What differs from one record to the next, or from one level of sweeps to the next, in numbers of its own."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from ...campaign.apart import TOLD, Kind, Told, floating, size_of, times_of, told_in
from ...campaign.campaign import Campaign
from ...fit import Fit, fit
from ...fit.rebuild import values_without
from ...units import format_quantity

MOVED = 0.3  # of its error bar: by so much a number is another one
_DRIVE = Told("drive", 100.0, "%", "does the force fall behind what it is called, or was a gain read wrongly?", 0.9,
              shared=True)  # fmt: skip


class Differing(NamedTuple):
    """Records or levels, by their `names`, that differ in one `kind` of numbers: `sizes` and `errors` (names, q),
    shares or (delays) samples, their mean zero over the fitted ones where the device has such a number too; the `fit`
    of the same model to the records as a device like the others would have given them; and how many `numbers` more
    than one device has it had."""

    kind: Kind | Literal["drive"]
    names: tuple[str, ...]
    sizes: np.ndarray
    errors: np.ndarray
    fit: Fit
    numbers: int

    @property
    def words(self) -> str:
        """What differs, for people."""
        return f"{_opening(self.kind)}: {', '.join(self._each)}. They are read so, held-out ones too: {self._told.why}"

    @property
    def _each(self) -> list[str]:
        """The number of each, with its error if it is one, and where it is."""
        traces, kind = self.fit.campaign.traces, self.kind
        if kind == "drive":
            where, unit, times = "at", _DRIVE.unit, [_DRIVE.times] * len(self.names)
            shown = [_DRIVE.times * s[0] for s in self.sizes]
        else:
            where, unit, times = "in", told_in(kind, traces, self.fit.model.device), [times_of(t, kind) for t in traces]
            shown = [size_of(t) for t in traces]

        def words(name: str, size: float, error: np.ndarray, times: float) -> str:
            known = len(error) == 1 and np.isfinite(error[0])
            doubt = f" ± {format_quantity(times * error[0], unit, 1)}" if known else ""
            return f"{'+' if size >= 0 else ''}{format_quantity(size, unit, 2)}{doubt} {where} {name}"

        return [words(*one) for one in zip(self.names, shown, self.errors, times, strict=True)]

    @property
    def _told(self) -> Told:
        return _DRIVE if self.kind == "drive" else TOLD[self.kind]

    def said_in(self, campaign: Campaign) -> Campaign:
        """The campaign with these words in its notes, in place of those that told other numbers of the kind; zeros are
        from now on fitted with every model."""
        told = without_words(campaign, self.kind)
        return replace(floating(told), notes=(*told.notes, self.words))

    def moved(self, before: Differing) -> bool:
        """Whether a number has moved by more than is little beside its error."""
        return bool(np.any(np.abs(self.sizes - before.sizes) > MOVED * self.errors))

    def begun(self, start: Fit) -> Fit:
        """The fit from which a walk had begun, with the records read so."""
        before = without_common_zero(start) if self._told.of_zero else start
        return fit(before.model, self.said_in(self.fit.campaign), initial=before.values)


def _opening(kind: Kind | Literal["drive"]) -> str:
    """What words of a kind begin with, whatever the numbers are."""
    which, told = ("levels", _DRIVE) if kind == "drive" else ("records", TOLD[kind])
    return f"The {which} agree only if each has a {told.what} of its own"


def without_words(campaign: Campaign, kind: Kind | Literal["drive"]) -> Campaign:
    """The campaign without a note of numbers of a kind."""
    notes = tuple(note for note in campaign.notes if not note.startswith(_opening(kind)))
    return replace(campaign, notes=notes)


def without_common_zero(fitted: Fit) -> Fit:
    """A fit without the constant of a sensor that has one in each record."""
    model, asked = fitted.model, fitted.campaign.effects
    common = [e.name for e in model.effects if e.is_constant and e.acts_on == "sensor" and e.name not in asked]
    if not common:
        return fitted
    for name in common:
        model = model - name
    return fit(model, fitted.campaign, initial=values_without(fitted, *common))


def numbers_of(fitted: Fit, kind: Kind) -> int:
    """How many numbers a fit has more where its records differ so."""
    return TOLD[kind].each * len(fitted.campaign.fitted) - TOLD[kind].shared
