"""What an effect remembers of a motion, or of a drive, that has repeated itself for ever.

    h(T) = Φ(h(0); x),   dh(0)/dx = (1 − ∂Φ/∂h)⁻¹ ∂Φ/∂x

A memory of the drive alone knows nothing of the motion: at a drive level and a frequency its periodic path is found by
itself, in closed form where the effect has one (`settled`), and is no unknown of the response. It is differentiated by
the frequency and its own few shapes, however many directions a model is differentiated along.

Source: the implicit function theorem; A. H. Nayfeh, B. Balachandran, Applied Nonlinear Dynamics, 1995, §6.5.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array, lax

from ..effects.effect import AbstractEffect
from .memory import Seen, memory_along, shaping
from .system import tangents

STUCK = 1e-12  # squared share below which a memory neither forgets nor moves: it stays where it is
_PERIODS = 2  # of Newton's method: a linear memory, or a play that is dragged, has settled after one


def steady_memory(
    effect: AbstractEffect, see: Callable[[Array], Seen], at: Array, names: tuple[str, ...] | None = None
) -> Array:
    """Hidden states (h, points) of an effect that a period has carried along for ever; a play that is stuck stays as
    it began.

    `see`: what the effect sees at the numbers `at`, (k,); the states are differentiable by those and by the effect's
    own parameters, or by those of some `names` only.
    """
    if not effect.state0():
        return jnp.zeros((0, 1))
    names, k = shaping(effect) if names is None else names, len(at)
    x, bent = _bent(effect, names, at)
    here, n = lax.stop_gradient(x), len(effect.state0())

    def along(hidden: Array, x: Array) -> tuple[Array, Array]:
        end, path = memory_along(bent(x[k:]), tuple(hidden), see(x[:k]))
        return jnp.stack(end), jnp.stack(path)

    axes = jnp.eye(n + len(x))

    def once_more(_: int, known: tuple[Array, ...]) -> tuple[Array, ...]:
        """Newton's step from one period, and what the path is from there to first order."""
        hidden = known[0]
        ahead = lambda axis: jax.jvp(along, (hidden, here), (axis[:n], axis[n:]))
        (end, path), (end_slopes, path_slopes) = jax.vmap(ahead, out_axes=(None, 0))(axes)
        left = jnp.eye(n) - end_slopes[:n].T
        missed = jnp.concatenate([(end - hidden)[None], end_slopes[n:]])
        moved = jnp.linalg.solve(left.T @ left + STUCK * jnp.eye(n), left.T @ missed.T).T
        paths = jnp.tensordot(moved, path_slopes[:n], 1)
        return hidden + moved[0], path + paths[0], path_slopes[n:] + paths[1:]

    begun = jnp.stack([jnp.asarray(h, float) for h in bent(here[k:]).begun(see(here[:k]).first)])
    points = len(see(here[:k]).voltage)
    known = (begun, jnp.zeros((n, points)), jnp.zeros((len(x), n, points)))
    _, path, slopes = lax.stop_gradient(lax.fori_loop(0, _PERIODS, once_more, known))
    return path + jnp.tensordot(x - here, slopes, 1)


def _bent(effect: AbstractEffect, names: tuple[str, ...], at: Array) -> tuple[Array, Callable[[Array], AbstractEffect]]:
    """The numbers `at` and the parameters of some names, (k + names,); and the effect with others of these."""
    fixed = effect.with_values(**{name: lax.stop_gradient(value) for name, value in effect.values.items()})
    x = jnp.concatenate([at, jnp.stack([jnp.asarray(effect.values[name], float) for name in names])] if names else [at])
    return x, lambda shapes: fixed.with_values(**dict(zip(names, shapes, strict=True)))


def driven_memory(effect: AbstractEffect, gain: Any, level: Any, frequency: Any, circle: Any) -> Array:
    """`steady_memory` of an effect that follows the drive U cos ωt alone; `circle`: cosine and sine of ωt, (2, points),
    on the half-step grid."""
    cosine, sine = circle

    def see(at: Array) -> Seen:
        (frequency,) = at
        omega, step = 2 * math.pi * frequency, 2.0 / (frequency * (len(cosine) - 1))
        voltage, rate, still = level * cosine, -level * omega * sine, jnp.zeros(len(cosine))
        return Seen(still, still, voltage, rate, still, step, omega, lax.stop_gradient(gain), 0.0)

    at = jnp.stack([frequency])
    if not effect.overrides("settled"):
        return steady_memory(effect, see, at)
    x, bent = _bent(effect, shaping(effect), at)
    here = lax.stop_gradient(x)

    def path(x: Array) -> Array:
        there, seen = bent(x[1:]), see(x[:1])
        # One point of the grid after the other: XLA would compute all of it again for every stage that reads it.
        one = lambda at: jnp.stack(there.settled(level, seen.drive(*at)))
        return lax.map(one, (seen.voltage, seen.rate)).T

    there, slopes = tangents(path, (here,), (jnp.eye(len(x)),))
    return there + jnp.tensordot(x - here, slopes, 1)
