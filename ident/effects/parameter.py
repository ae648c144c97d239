"""The numbers and words of an effect, declared where the physics is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

from ..errors import UserError

if TYPE_CHECKING:
    from .effect import AbstractEffect

Scale = Literal[
    "displacement",
    "velocity",
    "voltage",
    "period",
    "duration",
    "induction",
    "nearness",
    "squared_nearness",
    "slowness",
    "per_squared_velocity",
    "one",
]


class Expected(NamedTuple):
    """What is known of a parameter before any record is seen: `centre` ± `spread` in SI; for a positive parameter the
    spread is that of its logarithm. `source`: where it comes from, in words."""

    centre: float
    spread: float
    source: str


@dataclass(frozen=True)
class Parameter:
    """One number of an effect, declared where the physics is.

    An `amplitude` enters so that zero means absent. A `shape` (a gap, a time, a yield) is meaningless while the
    effect is off; its `grid` lists values to try and its `limits` where it keeps its meaning, in multiples of the
    data's own `scale`. What `refines` a law is held at its usual value, until the records clearly choose another.
    """

    kind: Literal["amplitude", "shape"]
    unit: str
    doc: str
    default: float
    positive: bool
    grid: tuple[float, ...]
    scale: Scale
    fitted: bool
    limits: tuple[float, float] | None = None
    one_sided: bool = False
    expected: Expected | None = None
    refines: bool = False
    name: str = ""

    def __set_name__(self, owner: type, name: str) -> None:
        object.__setattr__(self, "name", name)

    def __get__(self, effect: AbstractEffect | None, owner: type) -> Any:
        return self if effect is None else effect.values[self.name]


def amplitude(
    unit: str,
    doc: str = "",
    *,
    default: float = 0.0,
    positive: bool = False,
    one_sided: bool = False,
    fitted: bool = True,
    refines: bool = False,
    expected: Expected | None = None,
) -> Any:
    """Declare a parameter that switches the effect off when it is zero.

    **Arguments:** `unit` ("N/m^3"); `doc`, a few words for the help page; `default`, the value to start a fit from;
    `positive`, if a fit must keep it above zero; `one_sided`, if it may pass through zero on its way but means nothing
    below (a friction that drives): what ends there is not the effect that is missing; `fitted=False` holds it unless
    the campaign frees it, and `refines` at the usual value of the law (zero) unless the campaign frees it or a walk
    finds that the records clearly choose the law with it free; `expected`, what is known beforehand, which a posterior
    takes as its prior (a fit does not).
    """
    fitted = fitted and not refines
    return Parameter("amplitude", unit, doc, default, positive, (), "one", fitted, None, one_sided, expected, refines)


def shape(
    unit: str,
    doc: str = "",
    *,
    grid: tuple[float, ...],
    scale: Scale = "one",
    limits: tuple[float, float] | None = None,
    positive: bool = True,
    fitted: bool = True,
    refines: bool = False,
    expected: Expected | None = None,
) -> Any:
    """Declare a parameter that says how an effect looks, not how large it is.

    **Arguments:** `grid`, values worth trying in multiples of the data's `scale` ("displacement": its largest value in
    the records, likewise "velocity" and "voltage", "induction" the one over the other, "nearness" one over the
    displacement, "squared_nearness" its square, "slowness" one over the rms rate of the voltage, "per_squared_velocity"
    one over the square of the velocity; "period": 1/f0;
    "duration" of a record; "one": SI as written); `limits`, where it keeps its meaning, so that a fit cannot turn one
    effect into another (default: a third of the smallest to three times the largest of the grid). A fit stays inside;
    one of a shape that may be negative does not, but where it ends outside the effect is impossible, and there is no
    default. `refines` holds it at the middle of the grid, the usual value of the law, unless the campaign frees it or a
    walk finds that the records clearly choose the law with it free. `expected`: as of an amplitude.
    """
    if scale not in get_args(Scale):
        do = "write one of " + ", ".join(f'"{word}"' for word in get_args(Scale))
        raise UserError(f"a shape is scaled by {scale!r}, which is nothing that is known of the data", do=do)
    if not isinstance(grid, (tuple, list)) or not grid:
        raise UserError(f"grid = {grid!r} lists no values to try", do="write a few of them, as in grid=(0.1, 0.3, 1.0)")
    if limits is None and positive:
        limits = (min(grid) / 3, max(grid) * 3)
    default = grid[len(grid) // 2]
    fitted = fitted and not refines
    return Parameter("shape", unit, doc, default, positive, grid, scale, fitted, limits, False, expected, refines)


@dataclass(frozen=True)
class Choice:
    """A setting of an effect that is one of a few words; the first is the default."""

    words: tuple[str, ...]
    name: str = ""

    def __set_name__(self, owner: type, name: str) -> None:
        object.__setattr__(self, "name", name)

    def __get__(self, effect: AbstractEffect | None, owner: type) -> Any:
        return self if effect is None else effect.settings.get(self.name, self.words[0])


def choice(*words: str) -> Any:
    """Declare a setting that the campaign chooses by a word (`closure = "frame"`), the first if it says nothing."""
    return Choice(words)
