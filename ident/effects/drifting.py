"""What starts when the drive is switched on, and how long ago that was."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..campaign.record import Trace
from .effect import AbstractEffect, Drive, Scalar, choice, shape

_IN_MOTION = "in-motion"


class Drifting(AbstractEffect):
    """Base of the drifts: t counts from the first sample of a record that begins at rest.

    Where some records begin so and others in motion, t counts from a time `age` before the first sample of the latter,
    the same for all of them: just switched on, or as long ago as a record lasts, to begin with.
    """

    age = shape(
        "s", "time since switching-on where a record begins in motion, a", grid=(1e-3, 1.0), scale="duration",
        limits=(1e-4, 100.0),  # down to less than a sample: one that is said to be in motion may have begun at rest
    )  # fmt: skip
    begins = choice("at-rest", _IN_MOTION)

    @classmethod
    def told_by(cls, records: Sequence[Trace]) -> Mapping[str, str]:
        # Where all records begin alike, what had gone on before is part of the device, and an age would mean nothing.
        both = len({record.begins_in_motion for record in records}) > 1
        return {"begins": _IN_MOTION if both else "at-rest"}

    def unused(self) -> tuple[str, ...]:
        return () if self.begins == _IN_MOTION else ("age",)

    def since_switched_on(self, t: Scalar, drive: Drive) -> Scalar:
        """Time since the drive was switched on, s."""
        return t + self.age * drive.moving if self.begins == _IN_MOTION else t
