"""What held-out levels of sweeps say against a model, one number each, in sentences."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...campaign.record import SAME_LEVEL
from ...fit.own_number import OwnNumber
from ...fit.result import Fit
from ...units import ratio_text, significant
from .quantity import Scale, neat, show_in
from .tables import listed

_WHAT = {"drive": "its drive", "resonance": "its resonance", "quality": "its quality factor"}
_COMPARED = {"drive": ("larger", "smaller"), "resonance": ("higher", "lower"), "quality": ("higher", "lower")}
_ASK = {
    "drive": "Far from the resonance no spring and no damper does that: is the drive there what it is called, and the "
    "sensor's range the same?",
    "resonance": "Was the device warmer, or does its stiffness depend on the amplitude otherwise than in the model?",
    "quality": "Does the damping depend on the amplitude otherwise than in the model?",
}


def own_number_words(fit: Fit) -> list[str]:
    """One sentence for each held-out level that asks for a number of its own, the question behind the last of a
    kind."""
    found = []
    last = {one.kind: one for one in fit.own_numbers}
    for one in fit.own_numbers:
        (before, after), (was, now) = one.over_noise, one.over_peak
        text = (
            f"{_level(one, fit)}, held out, answers as if {_WHAT[one.kind]} were {_share(one)}: with that alone error "
            f"over noise is {ratio_text(after)} instead of {ratio_text(before)}, and the rms error "
            f"{significant(100 * now, 2)} instead of {significant(100 * was, 2)} % of the peak."
        )
        found.append(text + (f" {_ASK[one.kind]}" if last[one.kind] is one else ""))
    return found


def own_numbers_dict(fit: Fit) -> list[dict[str, Any]]:
    """What would explain records or levels that are held out, as numbers."""
    return [
        {
            "files": list(one.names),
            "drive": float(one.level / fit.campaign.sweeps[0].drive_channel.factor),
            "what": one.kind,
            "larger_by": float(one.share),
            "standard_error": float(one.error),
            "error_over_noise": [float(x) for x in one.over_noise],
            "error_over_peak": [float(x) for x in one.over_peak],
        }
        for one in fit.own_numbers
    ]


def _level(one: OwnNumber, fit: Fit) -> str:
    names, sweep = listed(list(one.names)), next(s for s in fit.campaign.sweeps if s.name == one.names[0])
    if np.ptp(sweep.level) < (SAME_LEVEL - 1) * one.level:
        return names
    return f"{neat(one.level / sweep.drive_channel.factor, 3)} {sweep.drive_channel.unit} of {names}"


def _share(one: OwnNumber) -> str:
    shown = show_in(abs(one.share), one.error, Scale(0.01, "%"))
    return f"{shown.value} ± {shown.error} % {_COMPARED[one.kind][0 if one.share > 0 else 1]}"
