"""Likenesses: why effects pass for one another, and what tells them apart.

An effect names in `alike` those that it shares, the closest first, so that what is said of two is the closest that both
name. Measured on simulated records of every effect of the library (share of one's trace that the other reproduces after
the linear part has taken what it can); the reasons are physics.
"""

from __future__ import annotations

from typing import NamedTuple


class Likeness(NamedTuple):
    """What effects share of which any two may be taken for each other.

    **Arguments:** `why` they are, and what would `separate` them, in words; `linear_exact`: on a device whose motion is
    linear no record of drive and displacement differs; `in_motion`: no record differs that was begun when the device
    had long been moving.
    """

    why: str
    separate: str
    linear_exact: bool = False
    in_motion: bool = False


LAG_ON_EITHER_SIDE = Likeness(
    why="a delay before and after a linear device reads the same",
    separate="no record of drive and displacement can; time the sensor alone, or add a second sensor",
    linear_exact=True,
)
RELAXES = Likeness(
    why="what comes late in the drive and in the support makes transfer functions with as many poles and zeros",
    separate="a record in which something else than the drive moves the stage (a load that is taken away, a tap)",
)
LEAKS = Likeness(
    why="what leaks away behind the sensor and what comes late in the drive make the same transfer function",
    separate="the instrument: switch it to DC, or look up its lower corner",
)
CONSTANT = Likeness(
    why="on a linear device a constant force only shifts the reading by a constant",
    separate="a record of the sensor with the stage blocked, or a dc bias if the device is nonlinear",
    linear_exact=True,
)
NEARLY_CONSTANT = Likeness(
    why="within one short record a slow drift is a constant",
    separate="a longer record, or one that begins before the drive is switched on",
    in_motion=True,
)
FOLLOWS_AT_ONCE = Likeness(
    why="far below its own resonance a second mode follows the voltage at once",
    separate="drive near or above the second mode, or in bursts",
)
CUBIC_LOSS = Likeness(
    why="at one frequency z²ż and ż³ slow the motion alike",
    separate="a sine with a dc bias, or a strong drive far from resonance",
)
CONSTANT_FRICTION = Likeness(
    why="where it hardly slides slowly, friction that falls is constant",
    separate="slow reversals: a record whose largest velocity is a few times that at which the force would fall",
)
SAME_LOSS = Likeness(
    why="at one amplitude these are the same loss; only the law by which it grows differs",
    separate="the highest voltage at resonance beside the lowest, and free decay after a burst",
)
STRETCHES = Likeness(
    why="a beam that is stretched as it bends stiffens with the square of the travel, as a cubic spring does",
    separate="the highest voltage at resonance and a dc bias: stress stiffens one way more than the other",
)
STIFFENS = Likeness(
    why="a stop that is touched gently stiffens as a cubic spring does",
    separate="the highest voltage at resonance: a stop bends sharply, a spring does not",
)
QUADRATIC_FORCE = Likeness(
    why="for small travel the force of an arch is quadratic",
    separate="the highest voltage at resonance and a dc bias",
)
SQUARE_OF_THE_VOLTAGE = Likeness(
    why="while the stage moves little in its gap, a plate attracts by V² alone",
    separate="the highest voltage at resonance, where the gap closes most",
)
BENT_RESONANCE = Likeness(
    why="in the fundamental a quadratic spring bends the resonance as a cubic one that softens does",
    separate="the mean of the response or its second harmonic, which only the quadratic one has; or a dc bias",
)
EVEN_HARMONICS = Likeness(
    why="at one amplitude both are a mean and even harmonics",
    separate="two levels: the one grows with the motion, the other with its square",
)
SECOND_ORDER = Likeness(
    why="z², zV and V² are the same constant and second harmonic where z follows V in one ratio",
    separate="records at half the resonance, at the resonance and with a dc bias",
)
LOOP_OF_THE_DRIVE = Likeness(
    why="three laws for one loop of the drive",
    separate="a multisine or changing levels well below resonance: the inner loops differ",
)
SATURATES = Likeness(
    why="at one frequency all are a drive that gives less at a higher voltage",
    separate="the third harmonic of a sine well below the resonance, at the highest voltage and at two frequencies",
)
SLOW_CHANGE = Likeness(
    why="all are a slow change within the record",
    separate="the same record at two frequencies, and repeated after a pause",
)
_FIRST_SECONDS = "the first seconds after switching on, at the highest level; or a pause, and the same again"
WARM_SPRING = Likeness(
    why="once it is as warm as it gets, a spring that heat softens follows the squared amplitude, as a cubic one does",
    separate=_FIRST_SECONDS,
)
WARM_DAMPER = Likeness(
    why="once it is as warm as it gets, damping that heat changes follows the squared amplitude, as a cubic one does",
    separate=_FIRST_SECONDS,
)
SHIFT_OF_PHASE = Likeness(
    why="at one frequency all are a shift of phase and gain",
    separate="two frequencies or more, one above the resonance, at two levels or more",
)
SAME_HARMONICS = Likeness(
    why="at one frequency a bent spring and a bent sensor make the same harmonics",
    separate="the same level below, at and above the resonance: a force is amplified there, a reading is not",
)
WITHIN_A_PITCH = Likeness(
    why="within half a pitch a force that repeats is a spring that bends",
    separate="a longer travel: beyond half a pitch the force comes back",
)
