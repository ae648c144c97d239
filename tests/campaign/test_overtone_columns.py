"""Columns of harmonics in the tables of sweeps: which are found, and what is said of those that cannot be read."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ident.campaign import read_campaign
from ident.campaign.record import Sweep
from ident.errors import UserError

F = np.linspace(90, 110, 41)
A = 1 / np.hypot(1 - (F / 100) ** 2, F / 5000) / 50


def _read(folder: Path, headers: str, columns: list[np.ndarray], more: str = "") -> Sweep:
    rows = "\n".join(",".join(f"{x:.6g}" for x in row) for row in zip(*columns, strict=True))
    (folder / "s.csv").write_text(f"{headers}\n{rows}\n")
    (folder / "campaign.toml").write_text(
        'device = { kind = "oscillator", output = "m" }\n[[record]]\n'
        f'file = "s.csv"\nkind = "sweep"\nlevel = "1 V"\n{more}\n'
    )
    return read_campaign(folder).sweeps[0]


@pytest.mark.parametrize(
    "name", ["A2 (um)", "amplitude 2f (um)", "2f amplitude [um]", "R2 (um)", "2nd harmonic (um)", "amp_2f_um",
             "second harmonic amplitude (um)", "harmonic 2 (um)", "harm2 (um)"],
)  # fmt: skip
def test_names_of_harmonics(tmp_path: Path, name: str) -> None:
    sweep = _read(tmp_path, f"frequency (Hz),amplitude (um),{name}", [F, A, A**2])
    (one,) = sweep.overtones
    assert one.order == 2
    np.testing.assert_allclose(one.amplitude, 1e-6 * A**2, rtol=1e-4)
    np.testing.assert_allclose(sweep.amplitude, 1e-6 * A, rtol=1e-4)


def test_rms_nanometres_and_names_given(tmp_path: Path) -> None:
    sweep = _read(tmp_path, "frequency (Hz),amplitude (um),A3 (nm rms),CH7 (nm)", [F, A, A, A],
                  'columns = { harmonic2 = "CH7" }')  # fmt: skip
    second, third = sweep.overtones
    assert (second.order, third.order) == (2, 3)
    np.testing.assert_allclose(third.amplitude, np.sqrt(2) * second.amplitude, rtol=1e-4)
    assert np.all(sweep.only(np.arange(3)).overtones[1].amplitude == third.amplitude[:3])


@pytest.mark.parametrize(
    ("header", "column", "more", "words"),
    [
        ("A2", A, "", "states no unit"),
        ("A2 (V)", A, "", "no unit of what the amplitude is in"),
        ("A2 (um)", -A, "", "cannot be negative"),
        ("A2 (um)", A, 'columns = { harmonic3 = "CH9" }', "fits 0 columns"),
    ],
)
def test_what_cannot_be_read_is_said(tmp_path: Path, header: str, column: np.ndarray, more: str, words: str) -> None:
    with pytest.raises(UserError, match=words):
        _read(tmp_path, f"frequency (Hz),amplitude (um),{header}", [F, A, column], more)


def test_a_unit_may_stand_in_the_campaign(tmp_path: Path) -> None:
    sweep = _read(tmp_path, "frequency (Hz),amplitude (um),A2", [F, A, A], 'units = { harmonic2 = "nm" }')
    np.testing.assert_allclose(sweep.overtones[0].amplitude, 1e-9 * A, rtol=1e-4)


def test_noise_of_a_harmonic_is_read_off_its_points(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    noisy = np.abs(0.5 * A**2 + 0.01 * (rng.standard_normal(41) + 1j * rng.standard_normal(41)))
    sweep = _read(tmp_path, "frequency (Hz),amplitude (um),A2 (um),A3 (um)",
                  [F, A, noisy, np.abs(0.01 * (rng.standard_normal(41) + 1j * rng.standard_normal(41)))])  # fmt: skip
    for one in sweep.overtones:
        assert 0.5e-8 < np.median(one.noise) < 1.7e-8
