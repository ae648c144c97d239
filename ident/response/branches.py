"""All steady responses of a model at a drive level: the amplitude-frequency curve with its folds and its stability.

The curve is followed by its length (pseudo-arclength continuation), so that it may turn back; the multipliers of the
period tell where the response is stable. All levels are followed side by side.

Source: H. B. Keller, Lectures on Numerical Methods in Bifurcation Problems, 1987, §4; A. H. Nayfeh, B. Balachandran,
Applied Nonlinear Dynamics, 1995, §6.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .periodic import BY_FREQUENCY, FREQUENCY, Look, Periodic, Seat, empty_look, ride

_CLOSE = 1e-4  # of the scale: the last step of Newton's method towards the curve, which leaves its square
_MOST = 1500  # points of a curve
_ROUNDS, _SETTLING = 8, 30  # of Newton's method at the next point, and without a neighbour
_TURN = 0.97  # cosine of the angle by which the curve may turn from point to point
_LONGEST, _SHORTEST = 0.25, 1e-5  # steps, in scales of the unknowns
_PAST = 0.7  # of the peak: beyond the band and below, the curve is past it
_BEYOND = 2.0  # widths of the band by which a curve may leave it and turn back
_MET = 0.01  # of the largest value of each unknown: so near to the end of one stretch another one has met it
_BOUND = 1e100  # scales that a period may carry the state, or its slope: beyond, the motion has no bound
_STABLE = 1e-6  # beyond the unit circle by which a multiplier may be off


class Fold(NamedTuple):
    """Where a curve turns back: after point `index`; `frequency`, Hz; `amplitude`, m."""

    index: int
    frequency: float
    amplitude: float


@dataclass(frozen=True, eq=False)
class Branch:
    """An amplitude-frequency curve of a model at one drive level, in the order of its length.

    **Arguments:** `unknowns`, (k, n + 2) y, s = 1, f; `along`, their derivatives by the length; `length`, (k,); `tone`,
    (k,) complex fundamental relative to the drive; `swing`, (k,) half the peak-to-peak value; `stable`, (k,); `gap`,
    the point after which a second stretch begins, where the curve was not followed from the one to the other.
    """

    level: float
    load: float
    unknowns: np.ndarray
    along: np.ndarray
    length: np.ndarray
    tone: np.ndarray
    swing: np.ndarray
    stable: np.ndarray
    gap: int | None = None

    @property
    def stretches(self) -> tuple[slice, ...]:
        """The points of each stretch."""
        n = len(self.length)
        return (slice(0, n),) if self.gap is None else (slice(0, self.gap + 1), slice(self.gap + 1, n))

    @property
    def frequency(self) -> np.ndarray:
        """(k,) Hz."""
        return self.unknowns[:, FREQUENCY]

    @property
    def folds(self) -> tuple[Fold, ...]:
        """Where the curve turns back, in the order of its length."""
        slope, found = self.along[:, FREQUENCY], []
        for k in np.flatnonzero(self._joined & (slope[:-1] * slope[1:] < 0)):
            part = _turning(self.length[k + 1] - self.length[k], *self.frequency[k : k + 2], *slope[k : k + 2])
            amplitude = np.abs(self.tone[k]) + part * (np.abs(self.tone[k + 1]) - np.abs(self.tone[k]))
            found.append(Fold(int(k), float(self.at(k, part)[FREQUENCY]), float(amplitude)))
        return tuple(found)

    @property
    def _joined(self) -> np.ndarray:
        """(k - 1,) whether the curve goes on from each point to the next."""
        return np.arange(len(self.length) - 1) != (-1 if self.gap is None else self.gap)

    def at(self, k: Any, part: Any) -> np.ndarray:
        """Unknowns (…, n + 2) between points k and k + 1, (…,), by the cubic through both and their slopes."""
        h, t = (self.length[np.add(k, 1)] - self.length[k])[..., None], np.asarray(part)[..., None]
        a, b = self.unknowns[k], self.unknowns[np.add(k, 1)]
        u, v = h * self.along[k], h * self.along[np.add(k, 1)]
        return (1 + 2 * t) * (1 - t) ** 2 * a + t * (1 - t) ** 2 * u + t**2 * (3 - 2 * t) * b - t**2 * (1 - t) * v

    def crossings(self, frequencies: np.ndarray) -> list[list[tuple[int, float]]]:
        """Where the curve passes each of some frequencies: after which points, and what part of the way to the next."""
        f = self.frequency
        before, after = f[:-1] - frequencies[:, None], f[1:] - frequencies[:, None]
        # A point that is hit ends the stretch before it and does not begin the next.
        first = np.isin(np.arange(len(f) - 1), [stretch.start for stretch in self.stretches])
        which, k = np.nonzero(self._joined & ((before * after < 0) | (after == 0) | ((before == 0) & first)))
        low, high, rising = np.zeros(len(k)), np.ones(len(k)), f[k + 1] > f[k]
        for _ in range(40 if len(k) else 0):
            middle = 0.5 * (low + high)
            short = (self.at(k, middle)[:, FREQUENCY] < frequencies[which]) == rising
            low, high = np.where(short, middle, low), np.where(short, high, middle)
        found: list[list[tuple[int, float]]] = [[] for _ in frequencies]
        for i, point, part in zip(which, k, 0.5 * (low + high), strict=True):
            found[i].append((int(point), float(part)))
        return found


def _turning(h: float, a: float, b: float, u: float, v: float) -> float:
    """Where between 0 and 1 the cubic with ends a, b and slopes u, v (per unit of length h) has no slope."""
    u, v = h * u, h * v
    roots = np.roots([3 * (2 * a - 2 * b + u + v), 2 * (-3 * a + 3 * b - 2 * u - v), u])
    inside = [float(x.real) for x in roots if abs(x.imag) < 1e-9 and -1e-9 <= x.real <= 1 + 1e-9]
    return inside[0] if inside else 0.5


@np.errstate(over="ignore", invalid="ignore")  # beyond a motion without bound nothing is followed
def follow(model: Periodic, levels: np.ndarray, loads: np.ndarray, bands: np.ndarray,
           sizes: np.ndarray) -> list[Branch]:  # fmt: skip
    """The curves of a model at levels (k,), V, under loads (k,), kg, each through a band of frequencies (k, 2), Hz.

    Where a curve that is followed from the low end does not come back to small amplitudes at the high end (its fold is
    far beyond the band, there is none, or no next point is found), it is followed from the high end, too.

    **Arguments:** `sizes`: (k,) the largest amplitudes to expect, m, which scale the length.
    """
    bands = np.broadcast_to(np.asarray(bands, float), (len(levels), 2))
    found, whole = _followed(model, levels, loads, bands, sizes, True)
    rest = np.flatnonzero(~whole)
    if len(rest):
        others, through = _followed(model, levels[rest], loads[rest], bands[rest], sizes[rest], False)
        for i, other, complete in zip(rest, others, through, strict=True):
            found[i] = other.turned() if complete else found[i].joined(other)
    return [path.branch(float(v), float(m)) for path, v, m in zip(found, levels, loads, strict=True)]


def _followed(model: Periodic, levels: np.ndarray, loads: np.ndarray, bands: np.ndarray, sizes: np.ndarray,
              rising: bool) -> tuple[list[_Path], np.ndarray]:  # fmt: skip
    """The curves from one end of the bands on, and (k,) whether each came out at the other, past its peak."""
    n, own = model.size, float(model.values[0])
    low, high = bands.T
    # In these units a linear resonance is about as wide as it is high.
    width = np.maximum(own / max(float(model.values[1]), 1.0), (high - low) / 200)
    first = _linear(model, levels, loads, low if rising else high)
    scale = np.column_stack([sizes, 2 * np.pi * own * sizes, _hidden_sizes(model, levels, loads, sizes),
                             np.ones(len(levels)), width])  # fmt: skip
    seat = Seat(np.asarray(levels, float), np.asarray(loads, float), scale)
    w, begun, _ = settle(model, first, seat)
    paths = [_Path() for _ in levels]
    tangent = np.zeros((len(levels), n + 1))
    tangent[:, n] = 1.0 if rising else -1.0
    seen = model.look(w, seat, BY_FREQUENCY)
    tangent = _tangents(seen, seat, tangent)
    step = np.full(len(levels), 0.05)
    active, whole = np.flatnonzero(begun), np.zeros(len(levels), bool)
    for i in active:
        paths[i].append(w[i], tangent[i], seen, i, seat)
    while len(active):
        there = seat.some(active)
        guess = w[active].copy()
        move = step[active, None] * tangent[active]
        guess[:, _UNKNOWN(n)] += move * there.scale[:, _UNKNOWN(n)]
        found, good, seen, rounds = _corrected(model, guess, there, tangent[active])
        turned = _tangents(seen, there, tangent[active])
        good &= np.einsum("ij,ij->i", turned, tangent[active]) > _TURN
        for j, i in enumerate(active):
            if good[j]:
                paths[i].length += float(step[i])
                w[i], tangent[i] = found[j], turned[j]
                paths[i].append(w[i], tangent[i], seen, j, there)
                step[i] = min(step[i] * (1.5 if rounds[j] <= 2 else 1.0), _LONGEST)
            else:
                step[i] *= 0.4
        f, peak = w[active, FREQUENCY], np.array([max(map(abs, paths[i].tones)) for i in active])
        bottom, top = low[active], high[active]
        small = np.array([abs(paths[i].tones[-1]) for i in active]) < _PAST * peak
        over = small & ((f > top) if rising else (f < bottom))
        whole[active[over]] = True
        on = (step[active] > _SHORTEST) & ~over & (f < top + _BEYOND * (top - bottom))
        on &= f > np.maximum(bottom - _BEYOND * (top - bottom), 0.1 * bottom)
        active = active[on & np.array([len(paths[i].points) < _MOST for i in active])]
    return paths, whole


def _hidden_sizes(model: Periodic, levels: np.ndarray, loads: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """(k, n - 2) how large the hidden states are where the stage moves as far as is expected; one where they rest. A
    curve is as long as its unknowns are far apart in these units."""
    around = np.full(len(levels), float(model.values[0]))
    turned = [ride(model, levels, around, np.asarray(loads, float), turn * sizes).hidden for turn in (1.0 + 0j, 1j)]
    found = np.hypot(*turned)
    return np.where(np.isfinite(found) & (found > 0), found, 1.0)


def settle(model: Periodic, unknowns: np.ndarray, seat: Seat) -> tuple[np.ndarray, np.ndarray, Look]:
    """Steady responses at given levels and frequencies from nearby ones; whether they were found; and the last look at
    each, moved on to them."""
    n, w = model.size, unknowns.copy()
    look, good, left = empty_look(len(w), n, n), np.zeros(len(w), bool), np.arange(len(w))
    for _ in range(_SETTLING):
        there = seat.some(left)
        seen = model.look(w[left], there, BY_FREQUENCY).along(slice(n))
        equations = seen.miss / there.scale[:, :n]
        matrix = np.moveaxis(seen.miss_slope / there.scale[None, :, :n], 0, 2)
        with np.errstate(invalid="ignore", over="ignore"):
            moved = -_least(matrix, equations[..., None])[..., 0]
        moved *= np.minimum(1.0, 0.5 / np.maximum(np.max(np.abs(moved[:, :2]), axis=1), 1e-300))[:, None]
        w[left, :n] += moved * there.scale[:, :n]
        look.put(left, seen.moved(moved))
        good[left] = _near(equations, moved)
        left = left[~good[left] & np.isfinite(equations).all(axis=1)]
        if not len(left):
            break
    return w, good, look


def _near(equations: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Whether the next step of Newton's method would be the square of a small one."""
    return np.maximum(np.max(np.abs(equations), axis=1), np.max(np.abs(moved), axis=1)) < _CLOSE


class _Path:
    """A curve while it is followed."""

    def __init__(self) -> None:
        self.points: list[np.ndarray] = []
        self.tangents: list[np.ndarray] = []
        self.lengths: list[float] = []
        self.tones: list[complex] = []
        self.swings: list[float] = []
        self.stable: list[bool] = []
        self.length = 0.0
        self.gap: int | None = None

    def append(self, w: np.ndarray, tangent: np.ndarray, seen: Look, j: Any, seat: Seat) -> None:
        n = len(w) - 2
        jacobian = seen.miss_slope[:n, j].T / seat.scale[j, :n, None] + np.eye(n)
        full = np.zeros(n + 2)
        full[_UNKNOWN(n)] = tangent * seat.scale[j, _UNKNOWN(n)]
        self.points.append(w.copy())
        self.tangents.append(full)
        self.lengths.append(self.length)
        self.tones.append(complex(seen.tone[j]))
        self.swings.append(float(seen.swing[j]))
        self.stable.append(bool(np.max(np.abs(np.linalg.eigvals(jacobian))) < 1 + _STABLE))

    def turned(self) -> _Path:
        """The same from its end to its beginning."""
        back = _Path()
        back.points, back.tones, back.swings = self.points[::-1], self.tones[::-1], self.swings[::-1]
        back.stable, back.tangents = self.stable[::-1], [-one for one in self.tangents[::-1]]
        back.lengths, back.length = [self.length - one for one in self.lengths[::-1]], self.length
        return back

    def joined(self, other: _Path) -> _Path:
        """This stretch from the low end and another from the high end, up to where they meet, if they do."""
        if not self.points:
            return other.turned()
        size = np.maximum(np.max(np.abs(np.array(self.points + other.points)), axis=0), 1e-300)
        ways = [np.max(np.abs(point - self.points[-1]) / size) for point in other.points]
        met = next((k for k, way in enumerate(ways) if way < _MET), len(other.points))
        if not met:
            return self
        there, both = other.turned(), _Path()
        kept = slice(len(other.points) - met, None)
        for name in ("points", "tangents", "tones", "swings", "stable"):
            setattr(both, name, getattr(self, name) + getattr(there, name)[kept])
        both.gap = len(self.points) - 1
        both.lengths = self.lengths + [self.length + 1.0 + one for one in there.lengths[kept]]
        both.length = both.lengths[-1]
        return both

    def branch(self, level: float, load: float) -> Branch:
        return Branch(level, load, np.array(self.points), np.array(self.tangents), np.array(self.lengths),
                      np.array(self.tones), np.array(self.swings), np.array(self.stable), self.gap)  # fmt: skip


def _UNKNOWN(n: int) -> list[int]:
    """Places of y and f among the unknowns."""
    return [*range(n), n + 1]


def _tangents(seen: Look, seat: Seat, before: np.ndarray) -> np.ndarray:
    """Unit tangents (points, n + 1) of the curve, in scaled unknowns, on the side of those before."""
    n = seen.miss.shape[1]
    matrix = np.moveaxis(seen.miss_slope / seat.scale[None, :, :n], 0, 2)
    bordered = np.concatenate([matrix, before[:, None, :]], axis=1)
    right = np.zeros((len(before), n + 1, 1))
    right[:, n] = 1.0
    with np.errstate(invalid="ignore"):
        found = _least(bordered, right)[..., 0]
    return found / np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-300)


def _corrected(
    model: Periodic, guess: np.ndarray, seat: Seat, tangent: np.ndarray
) -> tuple[np.ndarray, np.ndarray, Look, np.ndarray]:
    """Points of the curve in the plane across the tangent at the guess; whether they were found; the last look, moved
    on to them; after how many rounds."""
    n, w = model.size, guess.copy()
    look, good, rounds = empty_look(len(w), n, n + 1), np.zeros(len(w), bool), np.zeros(len(w), int)
    left = np.arange(len(w))
    for _ in range(_ROUNDS):
        there = seat.some(left)
        seen = model.look(w[left], there, BY_FREQUENCY)
        equations = seen.miss / there.scale[:, :n]
        matrix = np.moveaxis(seen.miss_slope / there.scale[None, :, :n], 0, 2)
        matrix = np.concatenate([matrix, tangent[left, None]], axis=1)
        right = np.concatenate([equations, np.zeros((len(left), 1))], axis=1)
        with np.errstate(invalid="ignore", over="ignore"):
            moved = -_least(matrix, right[..., None])[..., 0]
        moved = np.clip(moved, -0.5, 0.5)
        w[left[:, None], _UNKNOWN(n)] += moved * there.scale[:, _UNKNOWN(n)]
        look.put(left, seen.moved(moved))
        rounds[left] += 1
        good[left] = _near(equations, moved)
        left = left[~good[left] & np.isfinite(equations).all(axis=1)]
        if not len(left):
            break
    return w, good, look, rounds


def _linear(model: Periodic, levels: np.ndarray, loads: np.ndarray, frequency: np.ndarray) -> np.ndarray:
    """What the linear part alone would do, as unknowns (points, n + 2)."""
    linear, omega = model.equation.model, 2 * np.pi * frequency
    mass, (_, force) = linear.mass_of(model.values), model.equation.constants
    stiffness, damping = linear.spring_and_damper(model.values[0], model.values[1], mass)
    answer = model.values[2] * force * levels / (stiffness - (mass + loads) * omega**2 + 1j * omega * damping)
    hidden = np.zeros((len(levels), model.size - 2))
    return np.column_stack([answer.real, np.real(1j * omega * answer), hidden, np.ones(len(levels)), frequency])


def _least(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Steps (points, k, 1) that solve equations (points, k, k) = (points, k, 1) in the least squares; none where a
    motion has no bound, of which the equations say nothing."""
    known = (np.abs(matrix) < _BOUND).all(axis=(1, 2), keepdims=True) & (np.abs(right) < _BOUND).all(1, keepdims=True)
    matrix, right = np.where(known, matrix, 0.0), np.where(known, right, 0.0)
    size = np.maximum(np.max(np.abs(matrix), axis=(1, 2), keepdims=True), 1.0)
    turned = np.swapaxes(matrix, 1, 2) / size
    return np.linalg.solve(turned @ (matrix / size) + 1e-14 * np.eye(matrix.shape[1]), turned @ (right / size))
