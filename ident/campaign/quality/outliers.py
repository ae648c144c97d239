"""Single samples that leave the curve of their neighbours: dropped bits, sparks, cells that became zero."""

from __future__ import annotations

import numpy as np

_FAR = 12.0
"""Robust deviations from which on a sample is an outlier: none of 10⁶ normal ones lies beyond 5, and a bend of the
motion, which deviates in its neighbours too, is scaled by them."""

_NEIGHBOURS = 20  # on each side, that say how much the curve bends there
_MOST = 0.02  # of a record: more is no accident, but something that the device or the sensor does


def find_outliers(signal: np.ndarray) -> np.ndarray:
    """Numbers of the samples of a signal (n,) that are outliers, one by one from the worst; () if they are too many.

    A sample x_k is compared with the cubic through its four neighbours, (4 x_{k±1} − x_{k±2})/6. An outlier leaves the
    mark −1, 4, −6, 4, −1 in these deviations; a kink or a step, which a device can make, leaves −1, 2, −1 or
    −1, 3, −3, 1, and is told by its mark.
    """
    found: list[int] = []
    repaired = np.array(signal, dtype=float)
    for _ in range(int(_MOST * len(signal)) + 1):
        worst = _worst(repaired)
        if worst is None:
            return np.sort(np.array(found, dtype=int))
        found.append(worst)
        repaired[worst] = _expected(repaired, worst)
    return np.zeros(0, dtype=int)


def without_outliers(signal: np.ndarray, outliers: np.ndarray) -> np.ndarray:
    """The signal (n,) with each outlier replaced by the cubic through its neighbours."""
    repaired = np.array(signal, dtype=float)
    for k in outliers:
        repaired[k] = _expected(repaired, int(k))
    return repaired


def _expected(x: np.ndarray, k: int) -> float:
    return float((4 * (x[k - 1] + x[k + 1]) - x[k - 2] - x[k + 2]) / 6)


_MARKS = {
    "outlier": np.array([0.0, 1, -4, 6, -4, 1, 0]),
    "kink": np.array([0.0, 0, 1, -2, 1, 0, 0]),
    "step": np.array([0.0, 1, -3, 3, -1, 0, 0]),
    "step back": np.array([0.0, 0, 1, -3, 3, -1, 0]),
}


def off_neighbours(x: np.ndarray) -> np.ndarray:
    """(n,) by how much each sample leaves the cubic through its four neighbours; zero for the two at either end."""
    deviation = np.zeros(len(x))
    deviation[2:-2] = x[2:-2] - (4 * (x[1:-3] + x[3:-1]) - x[:-4] - x[4:]) / 6
    return deviation


def _worst(x: np.ndarray) -> int | None:
    """The sample that deviates most, if it is an outlier."""
    n = len(x)
    if n < 4 * _NEIGHBOURS:
        return None
    deviation = off_neighbours(x)
    size = np.abs(deviation)
    common = 1.4826 * float(np.median(size[2:-2]))
    for k in np.argsort(size)[::-1][:5]:
        k = int(k)
        if size[k] <= _FAR * common or k < 3 or k >= n - 3:
            continue
        near = np.r_[size[max(2, k - _NEIGHBOURS) : k - 2], size[k + 3 : min(n - 2, k + 3 + _NEIGHBOURS)]]
        alone = size[k] > _FAR * 1.4826 * float(np.median(near)) and size[k] > 4.0 * float(np.quantile(near, 0.75))
        if alone and _marked(deviation, k):
            return k
    return None


def _marked(deviation: np.ndarray, k: int) -> bool:
    part = deviation[k - 3 : k + 4]
    like = {name: abs(float(part @ mark)) / float(np.linalg.norm(mark)) for name, mark in _MARKS.items()}
    return max(like, key=lambda name: like[name]) == "outlier" and like["outlier"] > 0.985 * float(np.linalg.norm(part))
