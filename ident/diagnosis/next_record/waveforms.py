"""Records that a laboratory could take next: drives in words and as voltage against time, or free decays."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from ...campaign.campaign import Campaign
from ...campaign.device import drive_unit
from ...campaign.record import Channel, Measures
from ..where.words import hertz

Kind = Literal["sine", "biased", "burst", "multisine", "decay"]


@dataclass(frozen=True)
class Waveform:
    """A drive, switched on at time 0 with the device at rest; a constant part or a multisine rises over two periods. Or
    none, and the device is let go.

    **Arguments:** `volts`: peak of the alternating part; `hertz`: its frequency (multisine: its highest); `lowest`:
    of a multisine, Hz; `bias`: constant part, V; `off`: time at which a burst is switched off, s; `unit`: in which
    those volts are, if the drive is no voltage; `begun`: amplitude with which a decay begins, as the sensor reads it
    (SI), and `sensor`, in which unit that is said; `measures`: what the sensor reads.
    """

    kind: Kind
    volts: float
    hertz: float
    bias: float = 0.0
    lowest: float = 0.0
    off: float = np.inf
    unit: str = "V"
    begun: float = 0.0
    sensor: Channel = Channel("m", 1.0)
    measures: Measures = "displacement"

    def voltage(self, time: np.ndarray) -> np.ndarray:
        """Voltage at times (n,) s since the switch-on, V."""
        time = np.asarray(time, float)
        rise = 0.5 - 0.5 * np.cos(np.pi * np.clip(time * self.hertz / 2, 0.0, 1.0))
        if self.kind == "multisine":
            return rise * self._multisine(time)
        sine = self.volts * np.sin(2 * np.pi * self.hertz * time)
        return rise * self.bias + np.where(time < self.off, sine, 0.0)

    def _multisine(self, time: np.ndarray) -> np.ndarray:
        """Equal tones with phases −π k (k − 1)/K, which keep the peak low (M. R. Schroeder, 1970, IEEE Trans. IT
        16)."""
        spacing = self.lowest / max(int(self.lowest * (time[-1] - time[0])), 1)
        tones = np.arange(self.lowest, self.hertz * (1 + 1e-9), spacing)
        k = np.arange(len(tones))
        phase = -np.pi * k * (k - 1) / len(tones)
        wave = np.sin(2 * np.pi * np.outer(time, tones) + phase).sum(axis=1)
        return self.volts * wave / np.max(np.abs(wave))

    @property
    def words(self) -> str:
        """As a technician would write it."""
        volts, at = f"{self.volts:.3g} {self.unit}", f"{hertz(self.hertz)} Hz"
        if self.kind == "decay":
            return (
                f"free decay that begins with an amplitude of {self.begun / self.sensor.factor:.3g} {self.sensor.unit}"
            )
        if self.kind == "multisine":
            return f"multisine {volts} peak, {hertz(self.lowest)} to {at}, from rest"
        if self.kind == "biased":
            return f"sine {volts}, {at}, on {self.bias:.3g} {self.unit} dc, from rest"
        if self.kind == "burst":
            return f"sine {volts}, {at}, from rest, switched off after {1e3 * self.off:.4g} ms"
        return f"sine {volts}, {at}, from rest"


class Limits(NamedTuple):
    """What the laboratory can do: largest |voltage|, V, or of another drive its `unit`; lowest and highest frequency,
    Hz; time axis (n,), s; the `sensor` and what it `measures`; where nothing drives, the largest amplitude so far of a
    free decay, as that sensor reads it."""

    volts: float
    lowest: float
    highest: float
    time: np.ndarray
    unit: str = "V"
    begun: float = 0.0
    sensor: Channel = Channel("m", 1.0)
    measures: Measures = "displacement"


_MOST_SAMPLES = 2000  # of a proposed record
_PER_PERIOD = 12  # samples below which a sine is not worth recording
# Below, around and above the resonance; at 1/3 and 1/2 its own harmonics meet the resonance and are amplified.
_RATIOS = (0.2, 1 / 3, 0.5, 0.7, 0.9, 0.96, 1.0, 1.04, 1.1, 1.25, 1.6, 2.2)
_WEAK = (0.5, 0.96, 1.04)  # where a lower level or a bias says something that the full level does not
_LET_GO = (0.2, 0.5, 1.5, 2.0, 3.0)  # of the largest amplitude so far


def limits_of(campaign: Campaign, resonance: float) -> Limits:
    """The device's own limits, where it has none the range of the fitted traces; time axis like theirs. If no record
    was driven, and the device names no voltage, it can only be let go."""
    device, records = campaign.device, campaign.fitted
    step = float(np.median([r.step for r in records]))
    n = int(min(np.median([len(r.time) for r in records]), _MOST_SAMPLES))
    time = step * np.arange(n)
    if device.max_voltage is None and not campaign.sweeps and not any(r.driven for r in campaign.traces):
        size = lambda r: float(np.ptp(r.response[r.counted])) / 2 / (2 * np.pi * resonance) ** r.order
        last = max(records, key=size)
        begun = size(last) * (2 * np.pi * resonance) ** last.order
        return Limits(0.0, 0.0, 0.0, time, begun=begun, sensor=last.response_channel, measures=last.measures)
    volts = device.max_voltage or max(float(np.max(np.abs(r.drive))) for r in records)
    highest = min(device.max_frequency or 2.5 * resonance, 1 / (_PER_PERIOD * step))
    return Limits(volts, 3.0 / time[-1], highest, time, drive_unit(device), measures=records[0].measures)


def proposals(limits: Limits, resonance: float) -> list[Waveform]:
    """Sines at several levels and frequencies, on a bias, bursts that ring down, and multisines; free decays, where
    nothing drives."""
    if limits.begun:
        decay = Waveform("decay", 0.0, resonance, sensor=limits.sensor, measures=limits.measures)
        return [replace(decay, begun=part * limits.begun) for part in _LET_GO]
    usable = lambda f: limits.lowest <= f <= limits.highest
    full = limits.volts
    tones = [resonance * ratio for ratio in _RATIOS if usable(resonance * ratio)]
    found = [Waveform("sine", full, f) for f in tones]
    for f in [resonance * ratio for ratio in _WEAK if usable(resonance * ratio)]:
        found += [Waveform("sine", 0.4 * full, f), Waveform("biased", full / 2, f, bias=full / 2)]
    off = round(float(limits.time[-1]) / 2 * resonance) / resonance  # whole periods: the voltage ends at zero
    found += [Waveform("burst", full, resonance, off=off)] if usable(resonance) else []
    low, high = max(0.2 * resonance, limits.lowest), min(1.3 * resonance, limits.highest)
    if low < high:
        found.append(Waveform("multisine", full, high, lowest=low))
    return [replace(wave, unit=limits.unit, measures=limits.measures) for wave in found]
