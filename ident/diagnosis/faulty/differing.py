"""What differs from one record to the next, or from one level of sweeps to the next, in a number each."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from ...campaign.record import same_level
from ...fit import Fit, fit

Kind = Literal["stiffness", "sensitivity", "drive"]

_MOVED = 0.3  # of its error bar: by so much a number is another one


class Differing(NamedTuple):
    """Records or levels, by their `names`, that differ in one `kind` of number: `sizes` and `errors` (names,), as
    shares, the mean of the fitted ones zero, and the `fit` of the same model to the records as a device like the others
    would have given them."""

    kind: Kind
    names: tuple[str, ...]
    sizes: np.ndarray
    errors: np.ndarray
    fit: Fit

    @property
    def numbers(self) -> int:
        """How many numbers more than one device has: of the fitted ones, less the mean that is the device's."""
        campaign = self.fit.campaign
        if self.kind == "drive":
            return len(same_level(np.concatenate([sweep.level for sweep in campaign.fitted_sweeps]))) - 1
        return len(campaign.fitted) - 1

    @property
    def words(self) -> str:
        """What differs, for people."""
        share = 50.0 if self.kind == "stiffness" else 100.0  # a resonance moves by half of what its spring does
        who = "levels" if self.kind == "drive" else "records"
        where = "at" if self.kind == "drive" else "in"
        what = {"stiffness": "resonance", "sensitivity": "sensitivity", "drive": "drive"}[self.kind]
        asked = {
            "stiffness": "was the device warmer or otherwise loaded in some?",
            "sensitivity": "the sensor moved?",
            "drive": "does the force fall behind what it is called, or was a gain read wrongly?",
        }[self.kind]
        each = ", ".join(f"{share * s:+.2g} ± {share * e:.1g} % {where} {name}"
                         for name, s, e in zip(self.names, self.sizes, self.errors, strict=True))  # fmt: skip
        said = f"The {who} agree only if each has a {what} of its own: {each}."
        return f"{said} They are read so, held-out ones too: {asked}"

    def moved(self, before: Differing) -> bool:
        """Whether a number has moved by more than is little beside its error."""
        return bool(np.any(np.abs(self.sizes - before.sizes) > _MOVED * self.errors))

    def begun(self, start: Fit) -> Fit:
        """The fit from which a walk had begun, with the records read so."""
        campaign = self.fit.campaign
        told = replace(campaign, notes=(*campaign.notes, self.words))
        return fit(start.model, told, initial=start.values)
