"""Units of amplitudes as instruments write them: "Vrms", "um pp", "um/V", "dB", "dBVrms", "dB re 1 um/V".

Inside, an amplitude is the peak of a sine. What a unit does not say is taken as a peak; a ratio whose unit does not say
has one convention above and below its stroke, which cancels.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...units import find_unit

_SUFFIX = re.compile(
    r"(?P<unit>.*?)\s*[_\-. ]?\s*\(?"
    r"(?P<how>pk-?pk|p-?p|ptp|p2p|peak[- ]to[- ]peak|rms|eff|0-p|zero[- ]to[- ]peak|peak|pk|(?<=V)p)\)?",
    re.IGNORECASE,
)
_PEAKS = ("pk", "peak", "0-p", "zero-to-peak", "zero to peak", "p")
RMS, PEAK, PEAK_TO_PEAK = "rms", "peak", "peak-to-peak"
TO_PEAK = {RMS: math.sqrt(2.0), PEAK: 1.0, PEAK_TO_PEAK: 0.5, "": 1.0}
"""What turns a number of each convention into the peak of a sine; unsaid is taken as a peak."""


@dataclass(frozen=True)
class AmplitudeUnit:
    """How the numbers of an amplitude column are meant.

    **Arguments:**

    - `unit`: the plain unit of the response, "" where a bare "dB" leaves it open.
    - `per`: the plain unit of the drive by which it is divided; "" for an absolute amplitude.
    - `factor`: peak of the response in `unit` (for a ratio: per peak of the drive in `per`) for the number 1.
    - `decibel`: whether the numbers are 20 log10 of that.
    - `convention`: "rms", "peak", "peak-to-peak", or "" where the unit does not say.
    """

    unit: str
    per: str = ""
    factor: float = 1.0
    decibel: bool = False
    convention: str = ""

    def amplitudes(self, numbers: np.ndarray) -> np.ndarray:
        """(n,) peaks of the sine, in `unit`, or `unit` per `per`."""
        return self.factor * (10.0 ** (numbers / 20.0) if self.decibel else numbers)


def split_convention(text: str) -> tuple[str, str]:
    """A text without the word that tells how a sine is measured, and that word: "V_pp" is ("V", "peak-to-peak")."""
    match = _SUFFIX.fullmatch(text.strip())
    if match is None:
        return text, ""
    how = match["how"].lower()
    convention = RMS if how in ("rms", "eff") else PEAK if how in _PEAKS else PEAK_TO_PEAK
    return match["unit"].strip(" _-."), convention


def amplitude_unit(
    text: str, response: Callable[[str], bool], drive: Callable[[str], bool] | None = None
) -> AmplitudeUnit | None:
    """What a unit of amplitude means, or None if it is none.

    **Arguments:** `response`, `drive`: whether a plain unit is one of the response, and of the drive; without `drive`
    no ratio is accepted.
    """
    text = text.strip()
    decibel = re.fullmatch(r"dB\s*(?:re\.?|rel\.?|ref\.?)?\s*(?:1(?![\d.])\s*)?[(\[]?\s*(.*?)\s*[)\]]?", text)
    if decibel is None:
        return _linear(text, response, drive)
    reference = decibel[1].strip()
    if not reference:
        return AmplitudeUnit("", decibel=True)
    if text == "dBm" and response("V"):  # of the milliwatt in 50 ohm
        return AmplitudeUnit("V", "", math.sqrt(2 * 50e-3), True, RMS)
    found = _linear(reference, response, drive)
    if found is not None and text in ("dBV", "dBmV", "dBuV", "dBµV"):  # defined by the effective value
        found = replace(found, factor=TO_PEAK[RMS], convention=RMS)
    return None if found is None else replace(found, decibel=True)


def _linear(text: str, response: Callable[[str], bool], drive: Callable[[str], bool] | None) -> AmplitudeUnit | None:
    plain, how = split_convention(text)
    if response(plain):
        return AmplitudeUnit(plain, "", TO_PEAK[how], False, how)
    if drive is None or "/" not in text:
        return None
    above, below = (part.strip() for part in text.rsplit("/", 1))
    (unit, how_above), (per, how_below) = split_convention(above), split_convention(below)
    per = "V" if per in ("Volt", "volt") else per
    if not (response(unit) and drive(per)):
        return None
    return AmplitudeUnit(unit, per, TO_PEAK[how_above] / TO_PEAK[how_below], False, how_above)


def is_amplitude_unit(text: str, rare: bool = True) -> bool:
    """Whether a text is a unit of the amplitude of anything."""

    def known(name: str) -> bool:
        return find_unit(name, rare) is not None

    return amplitude_unit(text, known, known) is not None
