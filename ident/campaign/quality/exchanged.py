"""Records whose drive and response look exchanged beside the others: each has the noise that the other one has there.

An instrument adds the same noise to the same channel whatever stands in it, and columns of one unit, as those of an
oscilloscope, say nothing themselves.
"""

from __future__ import annotations

import math

import numpy as np

from ..campaign import Campaign
from ..drive import drive_rate
from ..held_drive import jumps
from ..period import noise_between
from ..record import Trace

_LEAST = 3  # records: of two that contradict each other neither is the usual one
_SLOW = 2 * math.pi / 10  # rad a sample: what is faster passes for noise
_APART = 2 * math.log(1.25)  # by which the noise of the two channels differs, both ways together
_NEAR = 0.25  # of that is left where they are read the other way round


def exchanged(campaign: Campaign) -> tuple[str, ...]:
    """A sentence for each record that is so."""
    traces = [record for record in campaign.traces if _tells(record)]
    if len(traces) < _LEAST:
        return ()
    noise = np.array([[_noise(record.drive), _noise(record.response)] for record in traces])
    found = []
    for k, record in enumerate(traces):
        usual = np.median(np.delete(noise, k, axis=0), axis=0)
        as_told = float(np.sum(np.abs(noise[k] - usual)))
        turned = float(np.sum(np.abs(noise[k] - usual[::-1])))
        if as_told > _APART and turned < _NEAR * as_told:
            found.append(
                f"{record.name}: its drive is as noisy as the response of the others, and its response as their drive: "
                "were the two columns exchanged?"
            )
    return tuple(found)


def _tells(record: Trace) -> bool:
    """Whether a record has two columns of one unit, and both are slow enough for their noise to be seen."""
    alike = record.driven and record.drive_channel.unit == record.response_channel.unit
    return alike and not jumps(record.drive) and max(drive_rate(record.drive), drive_rate(record.response)) < _SLOW


def _noise(signal: np.ndarray) -> float:
    """Logarithm of the noise of a signal (n,); one that has none is as if rounded to some digits of its size."""
    return 0.5 * math.log(max(noise_between(signal), 1e-12 * float(np.var(signal)), 1e-300))
