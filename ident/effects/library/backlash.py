"""Lost motion between the drive and what it pushes."""

from ..effect import AbstractEffect, Drive, Scalar, amplitude, shape
from ..likeness import LOOP_OF_THE_DRIVE, SHIFT_OF_PHASE
from ..memory import EDGE, drawn, played, within


class Backlash(AbstractEffect):
    """The force follows the drive through one play: F = −G a (V − p), p the play of half width r.

    Gears, a lead screw, a linkage with clearance: after each turn the drive runs through 2r before anything follows.
    a = 1 where all of the drive goes through the play, less where a part goes past it. The loop has parallel flanks and
    flat ends at every level beyond r, and no inner loops at levels below. A record is taken to start in the middle of
    the play; one that begins under voltage, to have risen to it from there.

    How sharply the play is met, k, is fitted where the records show it: see `pushed`.
    """

    name = "backlash"
    equation = "F = −G a (V − p), p the play of half width r"
    source = "Nordin & Gutman, Controlling mechanical systems with backlash: a survey, 2002, Automatica 38, 1633, §2"
    mistaken_for = ("prandtl-ishlinskii", "bouc-wen-drive", "drive-lag", "slew-limit", "pzt-hysteresis")
    alike = (LOOP_OF_THE_DRIVE, SHIFT_OF_PHASE)
    hidden_units = ("V",)

    share = amplitude("1", "share of the drive that goes through the play, a")
    width = shape("V", "half width of the play, r", grid=(0.03, 0.08, 0.2, 0.45), scale="voltage")
    # One play is found by searches at its usual 60, too, where six of unknown weights (`pushed`) ask for 24.
    edge = shape("1", "how sharply it is met, k", grid=(EDGE, 60.0, 150.0), limits=(4.0, 200.0), refines=True)

    def drive(self, hidden: tuple[Scalar, ...], drive: Drive, t: Scalar) -> Scalar:
        return -drive.gain * self.share * self.width * within((drive.V - hidden[0]) / self.width)

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,)

    def begun(self, drive: Drive) -> tuple[Scalar, ...]:
        return (drive.V - within(drive.V, self.width),)

    def follow(self, hidden: tuple[Scalar, ...], before: Drive, drive: Drive, step: Scalar) -> tuple[Scalar, ...]:
        return (drawn(hidden[0], before, drive, step, self.width, self.edge),)

    def settled(self, level: Scalar, drive: Drive) -> tuple[Scalar, ...]:
        return (drive.V - self.width * played(level, drive, self.width, self.edge),)
