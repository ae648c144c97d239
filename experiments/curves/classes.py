"""Which effects no curve tells apart: `python -m experiments.curves.classes`.

The signature of an effect is what it adds, when it is small, to the curves of a device, after the linear oscillator has
been refitted; two effects are alike where one signature is nearly a multiple of the other, in units of the noise. It is
all simulated by `sweeps`; the tool that is judged has no part in it.
"""

from __future__ import annotations

import argparse

import numpy as np

from experiments.hidden_effects.generator import Device
from experiments.hidden_effects.laws import INDEX, LAWS

from .generator import LEVELS, Noise, coefficient, measure

SMALL = 0.03  # misfit at which signatures are taken: ten noise floors, yet nearly linear in the coefficient
SAME = 0.99  # cosine between signatures from which on effects count as alike: 2 % of the misfit remain

UNSEEN = {
    "static-force": "constant",
    "sensor-offset": "constant",
    "sensor-drift": "needs a time that passes",
    "stiffness-drift": "needs a time that passes",
    "damping-drift": "needs a time that passes",
    "stiffness-heating": "only the mean that it comes to is left",
    "damping-heating": "only the mean that it comes to is left",
    "drive-heating": "only the mean that it comes to is left",
    "electrostriction": "even: a mean and a second harmonic",
    "electrostatic-force": "even: a mean and a second harmonic",
    "bilinear-stiffness": "even, and the same at every amplitude",
}
"""Effects without a fundamental of their own, or without more than a simpler one has: no curve can show them."""

_GROUPS = {
    True: (
        {"residual-stress", "cubic-stiffness"},
        {"second-mode", "sensor-crosstalk"},
        {"cubic-damping", "squeeze-film-damping"},
        {"drive-lag", "sensor-lag", "creep"},
    ),
    False: (
        {"residual-stress", "cubic-stiffness"},
        {"second-mode", "sensor-crosstalk", "sensor-lag", "drive-lag"},
        {"cubic-damping", "squeeze-film-damping"},
        {"prandtl-ishlinskii", "bouc-wen-drive"},
    ),
}

ALIKE: dict[bool, dict[str, set[str]]] = {
    phase: {
        law.name: {*law.alike, *(other for group in groups if law.name in group for other in group)} for law in LAWS
    }
    for phase, groups in _GROUPS.items()
}
"""With phase (True) and without: the effects that curves do not tell from each effect, as `main` finds with seed 1,
and those that no record tells from it."""

SEEN = tuple(law.name for law in LAWS if law.in_library and law.name not in UNSEEN)


def signature(device: Device, name: str, rng: np.random.Generator, phase: bool) -> np.ndarray | None:
    """(n,) what the effect adds to the curves of all levels in noise floors, the linear part refitted; None if the
    effect cannot reach the size."""
    c, s = np.zeros(len(LAWS)), np.zeros((len(LAWS), 3))
    s[INDEX[name]] = LAWS[INDEX[name]].shape(rng, True)
    c[INDEX[name]], reached = coefficient(device, name, s, SMALL)
    if not 0.5 * SMALL < reached < 2 * SMALL:
        return None
    noise, parts, slopes = Noise(), [], []
    for level in LEVELS:
        ratios, with_it = measure(device, level, c, s, coarse=True)
        _, without = measure(device, level, np.zeros(len(LAWS)), s, coarse=True)
        weight = 1 / np.hypot(noise.constant, noise.relative * np.abs(without))
        turn = np.exp(-1j * np.angle(without)) * weight
        h = ratios**2 - 1 - 1j * ratios / device.quality
        columns = np.stack([without, without / h, without * 1j * ratios / h], 1)
        added, slope = turn * (with_it - without), turn[:, None] * columns
        parts.append(np.concatenate([added.real, added.imag]) if phase else added.real)
        slopes.append(np.concatenate([slope.real, slope.imag]) if phase else slope.real)
    added, slope = np.concatenate(parts), np.concatenate(slopes)
    return added - slope @ np.linalg.lstsq(slope, added, rcond=None)[0]


def likeness(seed: int, phase: bool) -> tuple[list[str], np.ndarray]:
    """The effects that reach their size on a device, and (m, m) the cosines of their signatures."""
    rng = np.random.default_rng([seed, 23])
    quality = rng.uniform(20, 60)
    device = Device("platform", 500.0, quality, 1 / quality, rng.uniform(8e-6, 30e-6), 9.0, 1.0)
    found = {name: signature(device, name, rng, phase) for name in SEEN}
    names = [name for name, one in found.items() if one is not None]
    unit = np.stack([one / np.linalg.norm(one) for one in found.values() if one is not None])
    return names, np.abs(unit @ unit.T)


def main() -> None:
    """Print the effects that are alike, with phase and without."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    seed = parser.parse_args().seed
    for phase in (True, False):
        names, cosines = likeness(seed, phase)
        for group in _GROUPS[phase]:  # nothing is called alike that is not
            place = [names.index(name) for name in group]
            assert np.min(cosines[np.ix_(place, place)]) > SAME, group
        what = "amplitude and phase" if phase else "amplitude alone"
        print(f"{what}: {len(names)} of {len(SEEN)} effects reach the size")
        for i, name in enumerate(names):
            alike = [
                f"{names[j]} {cosines[i, j]:.3f}" for j in np.argsort(-cosines[i]) if j != i and cosines[i, j] > 0.95
            ]
            print(f"  {name:24} {', '.join(alike)}")


if __name__ == "__main__":
    main()
