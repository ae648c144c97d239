"""Hysteresis of the piezoelectric drive as a sum of plays."""

import jax.numpy as jnp
import numpy as np
from numpy.polynomial import legendre

from ..effect import AbstractEffect, Drive, Scalar, amplitude, shape
from ..likeness import LOOP_OF_THE_DRIVE, SHIFT_OF_PHASE
from ..memory import drawn, played, within

_PLAYS = 6
# Row j: the Legendre polynomials of order 0 to 5 at x_j. With as many orders as plays their weights are free.
_SHAPES = legendre.legvander(np.linspace(-1.0, 1.0, _PLAYS), _PLAYS - 1).tolist()


class PrandtlIshlinskii(AbstractEffect):
    """The drive force follows the voltage through plays: F = −(G/6) Σ_j w_j (V − p_j),
    w_j = w + u x_j + Σ_k u_k P_k(x_j), P_k the Legendre polynomial of order k = 2…5.

    p_j is the play operator of half width r_j = R (j − ½)/6, j = 1…6: p rests while |V − p| < r and is dragged along
    at the edge. x_j runs from −1 to 1. w is the gain that a small signal lacks against a large one, u tilts the
    weights towards wide plays; the u_k, which refine that, free all weights, for materials of a few plays with widths
    of their own. Loops nest and keep their shape at any frequency; of equal weights they widen as the square of the
    level, Rayleigh's law. Typical for PZT: w 5-40 %. As V is known, its parallel part is in the gain G already, and
    what is left is the loop.

    The edges are rounded (see `pushed`): a least-squares search stops where the edge of an exact play meets the largest
    drive. A record is taken to start unpoled, all p = 0; one that begins under voltage, to have risen to it from there.
    """

    name = "prandtl-ishlinskii"
    equation = "F = −(G/6) Σ (w + u x_j + Σ u_k P_k(x_j))(V − p_j), p_j the play of half width R (j − ½)/6"
    source = (
        "Kuhnen, Modeling, identification and compensation of complex hysteretic nonlinearities: a modified "
        "Prandtl-Ishlinskii approach, 2003, Eur. J. Control 9, 407, §2"
    )
    mistaken_for = ("bouc-wen-drive", "backlash", "pzt-hysteresis", "drive-lag", "creep", "slew-limit")
    alike = (LOOP_OF_THE_DRIVE, SHIFT_OF_PHASE)
    hidden_units = ("V",) * _PLAYS

    weight = amplitude("1", "mean weight of the plays, w")
    tilt = amplitude("1", "extra weight of the wide plays, u")
    order_2 = amplitude("1", "order 2 of the weights, u₂", refines=True)
    order_3 = amplitude("1", "order 3 of the weights, u₃", refines=True)
    order_4 = amplitude("1", "order 4 of the weights, u₄", refines=True)
    order_5 = amplitude("1", "order 5 of the weights, u₅", refines=True)
    reach = shape("V", "half width beyond the widest play, R", grid=(0.4, 0.8, 1.6), scale="voltage")

    def drive(self, hidden: tuple[Scalar, ...], drive: Drive, t: Scalar) -> Scalar:
        orders = (self.weight, self.tilt, self.order_2, self.order_3, self.order_4, self.order_5)
        weights = [sum(u * p for u, p in zip(orders, shapes, strict=True)) for shapes in _SHAPES]
        held = [within(drive.V - p, r) for p, r in zip(hidden, self._widths(), strict=True)]
        return -drive.gain / _PLAYS * sum(w * h for w, h in zip(weights, held, strict=True))

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0,) * _PLAYS

    def begun(self, drive: Drive) -> tuple[Scalar, ...]:
        return tuple(drive.V - within(drive.V, r) for r in self._widths())

    def follow(self, hidden: tuple[Scalar, ...], before: Drive, drive: Drive, step: Scalar) -> tuple[Scalar, ...]:
        return tuple(drawn(jnp.stack(hidden), before, drive, step, jnp.stack(self._widths())))

    def settled(self, level: Scalar, drive: Drive) -> tuple[Scalar, ...]:
        widths = jnp.stack(self._widths())
        return tuple(drive.V - widths * played(level, drive, widths))

    def _widths(self) -> list[Scalar]:
        return [self.reach * (j + 0.5) / _PLAYS for j in range(_PLAYS)]
