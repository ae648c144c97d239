"""What an effect remembers of a motion, or of a drive, that has repeated itself for ever.

    h(T) = Φ(h(0); x),   dh(0)/dx = (1 − ∂Φ/∂h)⁻¹ ∂Φ/∂x

A memory of the drive alone knows nothing of the motion: at a drive level and a frequency its periodic path is found by
itself, and is no unknown of the response. It is differentiated by the level, the frequency and its own few shapes,
however many directions a model is differentiated along.

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

STUCK = 1e-12  # squared share below which a memory neither forgets nor moves: it stays where it is
_PERIODS = 2  # of Newton's method: a linear memory, or a play that is dragged, has settled after one


def steady_memory(effect: AbstractEffect, see: Callable[[Array], Seen], at: Array) -> Array:
    """Hidden states (h, points) of an effect that a period has carried along for ever; a play that is stuck stays as
    it began.

    `see`: what the effect sees at the numbers `at`, (k,); the states are differentiable by those and by the effect's
    own parameters.
    """
    if not effect.state0():
        return jnp.zeros((0, 1))
    names, k = shaping(effect), len(at)
    fixed = effect.with_values(**{name: lax.stop_gradient(value) for name, value in effect.values.items()})
    x = jnp.concatenate([at, jnp.stack([jnp.asarray(effect.values[name], float) for name in names])] if names else [at])
    here, n = lax.stop_gradient(x), len(effect.state0())

    def along(hidden: Array, x: Array) -> tuple[Array, Array]:
        bent = fixed.with_values(**dict(zip(names, x[k:], strict=True)))
        end, path = memory_along(bent, tuple(hidden), see(x[:k]))
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

    begun = jnp.stack([jnp.asarray(h, float) for h in fixed.begun(see(here[:k]).first)])
    points = len(see(here[:k]).voltage)
    known = (begun, jnp.zeros((n, points)), jnp.zeros((len(x), n, points)))
    _, path, slopes = lax.stop_gradient(lax.fori_loop(0, _PERIODS, once_more, known))
    return path + jnp.tensordot(x - here, slopes, 1)


def driven_memory(effect: AbstractEffect, gain: Any, level: Any, frequency: Any, angle: Any) -> Array:
    """`steady_memory` of an effect that follows the drive U cos ωt alone; `angle`: (points,) rad, half-step grid."""

    def see(at: Array) -> Seen:
        level, frequency = at
        omega, step = 2 * math.pi * frequency, 2.0 / (frequency * (len(angle) - 1))
        voltage, rate = level * jnp.cos(angle), -level * omega * jnp.sin(angle)
        still = jnp.zeros(len(angle))
        return Seen(still, still, voltage, rate, still, step, omega, lax.stop_gradient(gain), 0.0)

    return steady_memory(effect, see, jnp.stack([level, frequency]))
