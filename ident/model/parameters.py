"""The parameters of a model: full name, unit, start, bound, prior; and the map to the coordinates of the optimiser."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..effects.parameter import Expected, Scale


@dataclass(frozen=True)
class ModelParameter:
    """One number of a model.

    **Arguments:**

    - `name`: "effect.parameter"; `unit`: of the SI value.
    - `value`: where a fit starts (SI); for a shape it is a multiple of the data's `scale` until the data are known.
    - `positive`: the value is fitted through its logarithm, so it cannot reach or cross zero.
    - `limits`: where a shape keeps its meaning, in multiples of the data's `limits_scale`; a fit stays inside.
    - `fitted`: whether a fit moves it; `grid`: other starting values.
    - `expected`: what is known of it before any record is seen; the prior of a posterior.
    """

    name: str
    unit: str
    value: float
    positive: bool = False
    fitted: bool = True
    kind: str = "amplitude"
    grid: tuple[float, ...] = ()
    scale: Scale = "one"
    limits: tuple[float, float] | None = None
    limits_scale: Scale = "one"
    doc: str = field(default="", compare=False)
    expected: Expected | None = field(default=None, compare=False)

    @property
    def effect(self) -> str:
        return self.name.rpartition(".")[0]
