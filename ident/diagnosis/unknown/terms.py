"""Simple functions of the coordinates: the words in which a formula for a missing effect is written.

A term has one amplitude. Its length, width or time, where it has one, is a shape number of the effect that will be
written from it. Values are SI.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import NamedTuple

import numpy as np

from ...effects.dependence import Side
from ...effects.effect import Scalar
from .splines import UNITS, Places, Size, lagging, plays, quick, sharp

_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_SLOWEST, _APART = 1.5, 0.5  # of waves: radians over half the range, and how far from one to the next
_QUICKEST = 0.8  # the same for each spline over it: four splines to a turn, which they follow to a hundredth
_HUMPS = (0.05, 0.1, 0.2, 0.4)  # widths of what acts near zero only, in parts of the largest value
TURNS = (0.006, 0.0125, 0.025, 0.05, 0.1, 0.2, 0.4, 0.7)  # widths of steps, up to a gentle saturation
_GAPS = (0.3, 0.45, 0.6, 0.75)  # of the largest value, where a contact begins
_LIMITS = (0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.75)  # of what is cut off; beside a straight line, of what is dead
_PEAKS = (0.1, 0.2, 0.4, 0.7, 1.2)  # of the largest value, where what falls again is largest
_STEP = 0.003  # width of a step that is too sharp to measure
_PLAYS = (0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7)  # half widths, in parts of the largest value
_LATE = (0.04, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 15.0, 50.0)  # periods; a fixed step follows none shorter
_CHANGES = (0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.5)  # durations
_KNOTS = 12  # of a table: as many as a fit still determines
_BASE = {"z": {"m": 1}, "v": {"m": 1, "s": -1}, "t": {"s": 1}, "rate": {"V": 1, "s": -1}}  # of the coordinates' units


class Number(NamedTuple):
    """A shape number of a term: `value` in SI `unit`; `fitted` if a fit may move it."""

    name: str
    unit: str
    value: float
    doc: str
    fitted: bool


class Knot(NamedTuple):
    """One spline of a table over a coordinate: the `index`-th of `count` from `low` to `high`, in parts of the term's
    number, less a constant `level` and a line of so much `slope` over the same clipped parts."""

    name: str
    low: float
    high: float
    count: int
    index: int
    level: float = 0.0
    slope: float = 0.0

    @property
    def table(self) -> tuple[str, float, float, int]:
        """What all splines of one table share."""
        return self.name, self.low, self.high, self.count


class Term(NamedTuple):
    """One function.

    **Arguments:**

    - `text`: for people ("z³"); `code`: in the names z, v, V, dV, t and `{n}`, its number, `{w}`, its `width`, and
      `{h}`, its hidden state.
    - `powers`: of the coordinates by whose units its amplitude's is divided; `written`: amplitude over the coefficient
      in the text, where the number in the code divides out a unit that the text keeps.
    - `memory`: "", "play" or "late"; of which coordinate is the first of `names`.
    - `kind`, of terms that differ in their number alone, or share one and say most together, as a sine and a cosine
      do; and `again`, the same with another number.
    - `law`: "g(z) v" for all terms that are a function of z times v; `width`: of a step that these are multiplied by.
    - `knot`: of a term that is one spline of a table, whose `code` is only what it is multiplied by.
    """

    text: str
    code: str
    names: tuple[str, ...]
    powers: tuple[tuple[str, int], ...]
    value: Callable[[Places], np.ndarray]
    number: Number | None = None
    written: float = 1.0
    memory: str = ""
    kind: str = ""
    again: Callable[[float], Term] | None = None
    width: Number | None = None
    law: str = ""
    knot: Knot | None = None

    @property
    def linear(self) -> bool:
        """Whether it is a coordinate itself."""
        return self.names == (self.text,)


def monomial(powers: Iterable[tuple[str, int]]) -> Term:
    """x^a y^b."""
    powers = tuple((name, p) for name, p in powers if p)
    text = " ".join(name if p == 1 else name + str(p).translate(_RAISED) for name, p in powers)
    code = " * ".join(name if p == 1 else f"{name}**{p}" for name, p in powers)
    value = lambda x: np.prod([x[name] ** p for name, p in powers], axis=0) if powers else np.ones_like(x["z"])
    return Term(text or "1", code or "1.0", tuple(n for n, _ in powers), powers, value)


def single(name: str, size: Size) -> list[Term]:
    """Functions of one coordinate."""
    n, largest, unit = name, size.largest, UNITS[name]
    found = [monomial([(n, p)]) for p in (1, 2, 3, 5)]
    if name == "t":
        return found[:2] + [_exponential(n, part * largest) for part in _CHANGES]
    length = lambda value, doc, fitted=True: Number(f"scale_{n}", unit, value, doc, fitted)
    step = step_width(n, size)
    found += [
        Term(f"|{n}|", f"jnp.abs({n})", (n,), ((n, 1),), lambda x: np.abs(x[n])),
        Term(f"|{n}| {n}", f"jnp.abs({n}) * {n}", (n,), ((n, 2),), lambda x: np.abs(x[n]) * x[n]),
        Term(f"sign({n})", f"jnp.tanh({n} / {{n}})", (n,), (), lambda x: sharp(x[n] / largest), step),
        Term(f"{n} √|{n}|", f"jnp.sign({n}) * jnp.abs({n} / {{n}}) ** 1.5", (n,), (),
             lambda x: np.sign(x[n]) * np.abs(x[n] / largest) ** 1.5,
             length(largest, f"{n} at which the term is its amplitude", False), largest**1.5),
    ]  # fmt: skip
    found += _family(f"step {n}", partial(_step, n, length), [part * largest for part in TURNS])
    waves = [0.5 * (size.high - size.low) / w for w in np.arange(_SLOWEST, _QUICKEST * size.pieces, _APART)]
    found += _family(f"wave {n}", partial(_wave, n, length, "sin", np.sin), waves)
    found += _family(f"wave {n}", partial(_wave, n, length, "cos", np.cos), waves)
    found += _family(f"hump {n}", partial(_hump, n, length), [part * largest for part in _HUMPS])
    found += _family(f"cut {n}", partial(_cut, n, length), [part * largest for part in _LIMITS])
    found += _family(f"peak {n}", partial(_peak, n, length), [part * largest for part in _PEAKS])
    for sign, end in ((1, size.high), (-1, -size.low)):
        gaps = [part * largest for part in _GAPS if part * largest < end]
        found += _family(f"contact {sign} {n}", partial(_contact, n, length, sign), gaps)
    return found


def step_width(name: str, size: Size, width: float = 0.0) -> Number:
    """Of a step of a `width` in parts of the largest value, or too sharp to measure."""
    value = (width or _STEP) * size.largest
    return Number(f"scale_{name}", UNITS[name], value, f"{name} over which the term turns", width > 0)


def _family(kind: str, of: Callable[[float], Term], values: Iterable[float]) -> list[Term]:
    """Terms that differ in one number."""
    again = lambda value: of(value)._replace(kind=kind, again=again)
    return [again(value) for value in values]


def _wave(n: str, length: Callable[..., Number], word: str, wave: np.ufunc, scale: float) -> Term:
    own, code = length(scale, "length of the wave over 2π"), f"jnp.{word}({n} / {{n}})"
    return Term(f"{word}({n}/{number(scale)})", code, (n,), (), lambda x: wave(x[n] / scale), own)


def _step(n: str, length: Callable[..., Number], width: float) -> Term:
    own = length(width, f"{n} over which the term turns")
    return Term(f"tanh({n}/{number(width)})", f"jnp.tanh({n} / {{n}})", (n,), (), lambda x: np.tanh(x[n] / width), own)


def _hump(n: str, length: Callable[..., Number], width: float) -> Term:
    value = lambda x: np.tanh(x[n] / (0.1 * width)) * np.exp(-((x[n] / width) ** 2))
    own = length(width, f"{n} beyond which the term dies out")
    code = f"jnp.tanh({n} / (0.1 * {{n}})) * jnp.exp(-(({n} / {{n}}) ** 2))"
    return Term(f"sign({n}) exp(−({n}/{number(width)})²)", code, (n,), (), value, own)


def _peak(n: str, length: Callable[..., Number], place: float) -> Term:
    """x/(1 + (x/w)²), as of a brake of eddy currents.

    Source: J. H. Wouterse, Critical torque and speed of eddy current brake with widely separated soft iron poles,
    1991, IEE Proc. B 138, 153.
    """
    own = length(place, f"{n} at which the term is largest")
    code, text = f"{n} / (1.0 + ({n} / {{n}}) ** 2)", f"{n}/(1 + ({n}/{number(place)})²)"
    return Term(text, code, (n,), ((n, 1),), lambda x: x[n] / (1.0 + (x[n] / place) ** 2), own)


def _contact(n: str, length: Callable[..., Number], sign: int, gap: float) -> Term:
    code = f"jnp.maximum({n} - {{n}}, 0.0)" if sign > 0 else f"jnp.maximum(-{n} - {{n}}, 0.0)"
    text = f"max({n} − {number(gap)}, 0)" if sign > 0 else f"max(−{n} − {number(gap)}, 0)"
    return Term(text, code, (n,), ((n, 1),), lambda x: np.maximum(sign * x[n] - gap, 0.0), length(gap, "gap"))


def _cut(n: str, length: Callable[..., Number], limit: float) -> Term:
    own = length(limit, f"{n} beyond which the term stays what it is")
    code, text = f"jnp.clip({n}, -{{n}}, {{n}})", f"clip({n}, ±{number(limit)})"
    return Term(text, code, (n,), ((n, 1),), lambda x: np.clip(x[n], -limit, limit), own)


def _exponential(n: str, time: float) -> Term:
    own = Number(f"scale_{n}", UNITS[n], time, "time in which the change dies out", True)
    return Term(f"(1 − exp(−{n}/{number(time)}))", f"-jnp.expm1(-{n} / {{n}})", (n,), (),
                lambda x: -np.expm1(-x[n] / time), own)  # fmt: skip


def paired(first: str, second: str, degree: int = 4) -> list[Term]:
    """Products of two coordinates."""
    both = [((first, a), (second, b)) for a in range(1, degree) for b in range(1, degree + 1 - a)]
    found = [monomial(powers) for powers in both]
    for a, b in ((first, second), (second, first)):
        if a != "t" and b != "t":
            code = f"jnp.abs({a}) * {b}"
            value = lambda x, a=a, b=b: np.abs(x[a]) * x[b]
            found.append(Term(f"|{a}| {b}", code, (a, b), ((a, 1), (b, 1)), value))
    return found


def remembered(name: str, size: Size, period: float) -> list[Term]:
    """Plays and relaxations of one coordinate, and its rate, a short delay; `period` of the resonance, s."""
    found = [monomial([("v", 1)]) if name == "z" else Term("V̇", "rate", ("rate",), (("rate", 1),), lambda x: x["rate"])]
    for width in (part * size.largest for part in _PLAYS):
        own = Number(f"width_{name}", UNITS[name], width, "half width of the play", True)
        value = lambda x, w=width: plays([x[name][0]], np.array([w]))[0]
        found.append(Term(f"play({name}; {number(width)})", "{h}", (name,), ((name, 1),), value, own, memory="play"))
    for time in (part * period for part in _LATE):
        own = Number(f"time_{name}", "s", time, "relaxation time", True)
        value = lambda x, tau=time: lagging(x[name], x["step"], tau, period)
        after = f"{name} relaxed in {number(time)} s"
        text, code = (f"({name} − {after})", f"({name} - {{h}})") if quick(time, period) else (f"({after})", "{h}")
        found.append(Term(text, code, (name,), ((name, 1),), value, own, memory="late"))
    return found


def table(name: str, size: Size, gauge: bool) -> list[Term]:
    """Cubic B-splines on evenly spaced knots, and a step: what a curve is written in that no simple term describes.

    `gauge`: whether a straight line is in the model already; then the outermost spline is left out.
    """
    found = bumps(name, size, gauge, _KNOTS)
    if name != "t":
        found += [t for t in single(name, size) if "exp" not in t.text and t.text.startswith(("|", "sign", "tanh"))]
    return found


def bumps(name: str, size: Size, gauge: bool, knots: int) -> list[Term]:
    """Cubic B-splines on evenly spaced knots; the outermost is left out if the model has their sum already."""
    low, high = size.low / size.largest, size.high / size.largest
    spacing = (high - low) / (knots - 3)
    own = Number(f"scale_{name}", UNITS[name], size.largest, f"{name} at which the table ends", False)
    found = []
    for k in range(gauge, knots):
        centre = low + (k - 1) * spacing
        value = lambda x, c=centre: bump((np.clip(x[name] / size.largest, low, high) - c) / spacing)
        text, knot = f"spline at {number(centre * size.largest)}", Knot(name, low, high, knots, k)
        found.append(Term(text, "1.0", (name,), (), value, own, knot=knot))
    return found


def amplitude_unit(side: Side, powers: Iterable[tuple[str, int]]) -> str:
    """Unit of what multiplies a product of coordinates: that of the side over theirs."""
    count = {"m": int(side == "sensor"), "s": 0, "V": 0}
    for name, power in powers:
        for symbol, own in _BASE.get(name, {"V": 1}).items():
            count[symbol] -= own * power
    write = lambda symbol, power: symbol if power == 1 else f"{symbol}^{power}"
    above = ([] if side == "sensor" else ["N"]) + [write(s, p) for s, p in count.items() if p > 0]
    below = "".join(f"/{write(s, -p)}" for s, p in count.items() if p < 0)
    return (" ".join(above) or "1") + below


def number(value: float) -> str:
    """A number as a formula has it: 3.1e9."""
    mantissa, _, power = f"{value:.3g}".partition("e")
    return f"{mantissa}e{int(power)}" if power else mantissa


def bump(x: Scalar) -> Scalar:
    """Cubic B-spline of whole-numbered knots: 2/3 at its centre, 0 from ±2."""
    far = abs(x)
    return (np.maximum(2 - far, 0.0) ** 3 - 4 * np.maximum(1 - far, 0.0) ** 3) / 6
