"""Effects that are known to pass for one another: why, and what tells them apart.

Measured on simulated records of every effect (share of one's trace that the other reproduces after the linear part has
taken what it can); the reasons are physics.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from ...effects.effect import AbstractEffect


class Equivalence(NamedTuple):
    """Effects of which any two may be taken for each other.

    **Arguments:** `linear_exact`: on a device whose motion is linear no record of drive and displacement differs;
    `in_motion`: no record differs that was begun when the device had long been moving.
    """

    names: frozenset[str]
    why: str
    separate: str
    linear_exact: bool = False
    in_motion: bool = False


def _of(names: str, why: str, separate: str, linear_exact: bool = False, in_motion: bool = False) -> Equivalence:
    return Equivalence(frozenset(names.split()), why, separate, linear_exact, in_motion)


# The closest relations first: the first entry that holds both names is the one that is told.
EQUIVALENCES: tuple[Equivalence, ...] = (
    _of("sensor-lag drive-lag", "a delay before and after a linear device reads the same",
        "no record of drive and displacement can; time the sensor alone, or add a second sensor", True),
    _of("creep viscoelastic-support",
        "what comes late in the drive and in the support makes transfer functions with as many poles and zeros",
        "a record in which something else than the drive moves the stage (a load that is taken away, a tap)"),
    _of("ac-coupling creep",
        "what leaks away behind the sensor and what comes late in the drive make the same transfer function",
        "the instrument: switch it to DC, or look up its lower corner"),
    _of("static-force sensor-offset", "on a linear device a constant force only shifts the reading by a constant",
        "a record of the sensor with the stage blocked, or a dc bias if the device is nonlinear", True),
    _of("static-force sensor-offset sensor-drift", "within one short record a slow drift is a constant",
        "a longer record, or one that begins before the drive is switched on", in_motion=True),
    _of("sensor-crosstalk second-mode", "far below its own resonance a second mode follows the voltage at once",
        "drive near or above the second mode, or in bursts"),
    _of("cubic-damping squeeze-film-damping", "at one frequency z²ż and ż³ slow the motion alike",
        "a sine with a dc bias, or a strong drive far from resonance"),
    _of("coulomb-friction stribeck-friction", "where it hardly slides slowly, friction that falls is constant",
        "slow reversals: a record whose largest velocity is a few times that at which the force would fall"),
    _of("quadratic-damping cubic-damping squeeze-film-damping coulomb-friction bouc-wen stribeck-friction",
        "at one amplitude these are the same loss; only the law by which it grows differs",
        "the highest voltage at resonance beside the lowest, and free decay after a burst"),
    _of("cubic-stiffness end-stop residual-stress", "a stop that is touched gently stiffens as a cubic spring does",
        "the highest voltage at resonance: a stop bends sharply, a spring does not"),
    _of("quadratic-stiffness arch-force residual-stress", "for small travel the force of an arch is quadratic",
        "the highest voltage at resonance and a dc bias"),
    _of("electrostriction electrostatic-force", "while the stage moves little in its gap, a plate attracts by V² alone",
        "the highest voltage at resonance, where the gap closes most"),
    _of("quadratic-stiffness cubic-stiffness",
        "in the fundamental a quadratic spring bends the resonance as a cubic one that softens does",
        "the mean of the response or its second harmonic, which only the quadratic one has; or a dc bias"),
    _of("bilinear-stiffness quadratic-stiffness", "at one amplitude both are a mean and even harmonics",
        "two levels: the one grows with the motion, the other with its square"),
    _of("quadratic-stiffness electrostriction voltage-stiffness residual-stress electrostatic-force",
        "z², zV and V² are the same constant and second harmonic where z follows V in one ratio",
        "records at half the resonance, at the resonance and with a dc bias"),
    _of("prandtl-ishlinskii bouc-wen-drive pzt-hysteresis", "three laws for one loop of the drive",
        "a multisine or changing levels well below resonance: the inner loops differ"),
    _of("creep stiffness-drift damping-drift sensor-drift", "all are a slow change within the record",
        "the same record at two frequencies, and repeated after a pause"),
    _of("sensor-lag drive-lag sensor-crosstalk second-mode viscoelastic-support creep prandtl-ishlinskii "
        "bouc-wen-drive pzt-hysteresis bouc-wen ac-coupling", "at one frequency all are a shift of phase and gain",
        "two frequencies or more, one above the resonance, at two levels or more"),
    _of("sensor-nonlinearity cubic-stiffness quadratic-stiffness end-stop electrostriction arch-force residual-stress "
        "bilinear-stiffness",
        "at one frequency a bent spring and a bent sensor make the same harmonics",
        "the same level below, at and above the resonance: a force is amplified there, a reading is not"),
)  # fmt: skip

_OTHERWISE = "records at other levels and frequencies"
_SIDES = "the same level below, at and above the resonance: it amplifies and turns a force, but not a reading"


def equivalence(one: str, other: str) -> Equivalence | None:
    """The closest known relation between two effects."""
    return next((e for e in EQUIVALENCES if one in e.names and other in e.names), None)


def what_separates(one: type[AbstractEffect], other: type[AbstractEffect]) -> str:
    """What tells two effects apart, in words."""
    known = equivalence(one.name, other.name)
    if known is not None:
        return known.separate
    sides = {one.acts_on, other.acts_on}
    return _SIDES if "sensor" in sides and len(sides) == 2 else _OTHERWISE


def exact_partners(name: str, library: Iterable[str], linear: bool, in_motion: bool) -> list[str]:
    """Effects of the library that no record tells from this one, of a linear device or begun in motion."""
    exact = (
        e for e in EQUIVALENCES if name in e.names and ((e.linear_exact and linear) or (e.in_motion and in_motion))
    )
    return sorted(set().union(*(e.names - {name} for e in exact)) & set(library))
