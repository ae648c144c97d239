"""Records that differ in a number each may be one that differs from all the others: then not the device changes, but
that record is suspect."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...campaign.quality.suspect import Kind, Suspect
from ..records.differing import Differing
from .nuisance import Nuisance
from .suspects import LIKELY
from .words import words_of

_ALIKE = 0.1  # of what one is off: the others differ by no more
_FEWEST = 4  # records: of three, two agree by chance
_FAULTS: dict[str, tuple[Kind, str, Callable[[float, float], float]]] = {
    # A resonance moves by half of what its spring does, and is read too low where time runs too slowly.
    "stiffness": ("time-scale", "1", lambda own, usual: ((1 + own) / (1 + usual)) ** 0.5),
    "sensitivity": ("gain", "1", lambda own, usual: (1 + own) / (1 + usual)),
    "delay": ("delay", "samples", lambda own, usual: own - usual),
}
"""The fault, its unit and its size, by what differs: the record's own number, and that of the others."""


def odd_one(found: Differing) -> Suspect | None:
    """The record that alone differs from the others, with its fault, if there is one."""
    if found.kind not in _FAULTS or len(found.names) < _FEWEST:
        return None
    sizes = found.sizes[:, 0]
    i = int(np.argmax(np.abs(sizes - np.median(sizes))))
    others = np.delete(sizes, i)
    usual = float(np.mean(others))
    if np.max(np.abs(others - usual)) > _ALIKE * abs(sizes[i] - usual):
        return None
    kind, unit, size_of = _FAULTS[found.kind]
    size = size_of(float(sizes[i]), usual)
    told = Nuisance(kind, size, unit, 1.0, found.fit.campaign.traces[i])
    words = f"{words_of(told, ())}; so read, it agrees with all the others, and these with one another"
    return Suspect(found.names[i], kind, size, unit, LIKELY, words)
