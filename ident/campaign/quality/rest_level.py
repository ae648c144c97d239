"""The level on which a free decay comes to rest: from there its displacements are counted."""

from __future__ import annotations

import numpy as np

_CYCLES = 8  # in the record, of its strongest line: fewer do not average out under the window


def rest_level(response: np.ndarray) -> float | None:
    """The equilibrium of a ring-down, in the unit of the response (n,); None if the record shows too few cycles of it.

    The mean of the second half under a Hann window, which lets less than 1e-3 of an oscillation of four cycles pass. A
    force law without symmetry shifts the mean of a large motion, hence the later half.

    Source: F. J. Harris, "On the use of windows for harmonic analysis", Proc. IEEE 66 (1978) 51, §V.
    """
    power = np.abs(np.fft.rfft(response - np.mean(response))) ** 2
    cycles = 1 + int(np.argmax(power[1:]))
    if cycles < _CYCLES:
        return None
    late = response[len(response) // 2 :]
    window = np.hanning(len(late) + 2)[1:-1]
    return float(np.sum(window * late) / np.sum(window))
