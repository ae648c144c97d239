"""The level on which a free decay comes to rest: from there its displacements are counted, if no driven record shows
the same level."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..record import Record, Trace

_CYCLES = 8  # in the record, of its strongest line: fewer do not average out under the window


def rest_level(response: np.ndarray) -> float | None:
    """The equilibrium of a ring-down, in the unit of the response (n,); None if the record shows too few cycles of it.

    The mean of the second half under a Hann window, which lets less than 1e-3 of an oscillation of four cycles pass. A
    force law without symmetry shifts the mean of a large motion, hence the later half.

    Source: F. J. Harris, "On the use of windows for harmonic analysis", Proc. IEEE 66 (1978) 51, §V.
    """
    power = np.abs(np.fft.rfft(response - np.mean(response))) ** 2
    cycles = 1 + int(np.argmax(power[1:]))
    if cycles < _CYCLES:
        return None
    late = response[len(response) // 2 :]
    window = np.hanning(len(late) + 2)[1:-1]
    return float(np.sum(window * late) / np.sum(window))


def counted_from_rest(records: Sequence[Record], notes: list[str]) -> list[Record]:
    """The records with the displacements of free decays counted from where they come to rest, which `notes` then say.

    Driven records beside them know the zero of their common sensor too: where they move about a level that is nearer
    to the decay's than zero is, it is one offset of all, which a model finds.
    """
    common = [float(np.mean(r.across(r.response))) for r in records if isinstance(r, Trace) and r.driven]
    found: list[Record] = []
    for record in records:
        level = rest_level(record.across(record.response)) if isinstance(record, Trace) and not record.driven else None
        if not isinstance(record, Trace) or level is None or (common and abs(level - np.median(common)) < abs(level)):
            found.append(record)
            continue
        shown = f"{level / record.response_channel.factor:.6g} {record.response_channel.unit}"
        told = f"displacements are counted from {shown}, the level on which the decay comes to rest."
        notes.append(f"{record.name}: {told}")
        found.append(replace(record, response=record.response - level))
    return found
