"""An amplifier that cannot follow a fast drive."""

import jax.numpy as jnp

from ..effect import AbstractEffect, Drive, Scalar, amplitude, shape
from ..likeness import SHIFT_OF_PHASE

_FAINT = 1e-30  # V/s and V: nothing drives
_LEAST = 1e-6  # of a turn: where a limit just touches, the beginning of the ramp has no slope


class SlewLimit(AbstractEffect):
    """The force follows a voltage that changes no faster than S: F = G a (w − V), ẇ = (V − w)/τ, between −S and S.

    An amplifier that drives the capacitance of a PZT with a limited current: a sine of amplitude U and frequency ω is
    let pass while U ω < S, and becomes a triangle beyond 1.9 S. τ is its small-signal bandwidth, as of `drive-lag`, and
    a, 1 for an amplifier, the share of the drive that goes through it. Exact between the points of the solver's grid
    but where the limit sets in or ends. On settled curves the lag is taken before the limit, which is exact for either
    alone; where both act that is 4 % of U off at ωτ = 0.13, and in proportion to τ.
    """

    name = "slew-limit"
    equation = "F = G a (w − V), ẇ = (V − w)/τ, |ẇ| ≤ S"
    source = "Sedra & Smith, Microelectronic Circuits, 2010, §2.7.2 (slew rate)"
    mistaken_for = ("drive-lag", "backlash", "prandtl-ishlinskii", "bouc-wen-drive", "pzt-hysteresis")
    alike = (SHIFT_OF_PHASE,)
    steps_per_period = 80
    hidden_units = ("V",)

    share = amplitude("1", "share of the drive that is limited, a")
    slowness = shape("s/V", "inverse of the fastest change, 1/S", grid=(0.7, 1.1, 1.8), scale="slowness")
    time = shape("s", "time constant, τ", grid=(1e-3, 0.02), scale="period")

    def drive(self, hidden: tuple[Scalar, ...], drive: Drive, t: Scalar) -> Scalar:
        return drive.gain * self.share * (hidden[0] - drive.V)

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)  # the voltage is switched on with the record

    def follow(self, hidden: tuple[Scalar, ...], before: Drive, drive: Drive, step: Scalar) -> tuple[Scalar, ...]:
        rate = (drive.V - before.V) / step
        kept = jnp.exp(-step / self.time)
        free = drive.V - self.time * rate + kept * (hidden[0] - before.V + self.time * rate)
        most = step / self.slowness
        return (hidden[0] + jnp.clip(free - hidden[0], -most, most),)

    def settled(self, level: Scalar, drive: Drive) -> tuple[Scalar, ...]:
        turn = drive.omega * self.time
        late = (drive.V - self.time * drive.rate) / (1.0 + turn**2)
        rate = (drive.rate + drive.omega * turn * drive.V) / (1.0 + turn**2)
        size = jnp.maximum(jnp.abs(level) / jnp.sqrt(1.0 + turn**2), _FAINT)
        limit = 1.0 / (self.slowness * jnp.maximum(size * drive.omega, _FAINT))  # of the fastest change of the sine
        slow = jnp.minimum(limit, 1.0 - _LEAST)
        # Rising, it leaves the sine where this becomes too fast, or meets it there again after the last ramp.
        begin = -jnp.minimum(jnp.arccos(slow), jnp.arcsin(jnp.minimum(slow * jnp.pi / 2, 1.0 - _LEAST)))
        phase = jnp.mod(jnp.arctan2(late * drive.omega, rate) - begin, 2 * jnp.pi)
        way = jnp.where(phase < jnp.pi, 1.0, -1.0)
        since = jnp.mod(phase, jnp.pi)
        ramp = jnp.minimum(jnp.sin(begin) + slow * since, jnp.sin(begin + since))
        return (jnp.where(limit < 1.0, size * way * ramp, late),)
