"""What columns explain is told by their inner products as by the columns themselves."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.diagnosis.linearised.basis import orthonormal
from ident.diagnosis.linearised.histories import Histories
from ident.diagnosis.linearised.inner import inner

N = 200


def bench(seed: int, absorbs: int) -> SimpleNamespace:
    rng = np.random.default_rng(seed)
    absorbed = orthonormal(rng.standard_normal((absorbs, N)))
    residual = rng.standard_normal(N)
    residual -= absorbed @ (absorbed.T @ residual)
    project = lambda rows: rows - (rows @ absorbed) @ absorbed.T
    return SimpleNamespace(absorbed=absorbed, residual=residual, project=project)


@given(st.integers(0, 1000), st.integers(0, 5), st.integers(1, 4), st.floats(-12, 12))
def test_drop_and_sizes_are_those_of_the_columns(seed: int, absorbs: int, q: int, decades: float) -> None:
    on, rng = bench(seed, absorbs), np.random.default_rng(seed + 1)
    rows = 10.0 ** (decades * rng.uniform(size=(q, 1))) * rng.standard_normal((q, N))
    (seen,) = inner(rows[None], on.absorbed, on.residual)
    kept = on.project(rows)
    basis = orthonormal(kept, rows)
    assert seen.drop == pytest.approx(float(np.sum((basis.T @ on.residual) ** 2)), rel=1e-8)
    lengths = np.linalg.norm(kept, axis=1)
    sizes = np.linalg.lstsq((kept / lengths[:, None]).T, on.residual, rcond=1e-10)[0] / lengths
    np.testing.assert_allclose(seen.sizes * lengths, sizes * lengths, rtol=1e-7, atol=1e-9)


def test_what_the_model_can_do_itself_and_what_has_no_bound_say_nothing() -> None:
    on = bench(3, 2)
    able = 5.0 * on.absorbed.T
    (seen,) = inner(able[None], on.absorbed, on.residual)
    assert seen.drop is None
    endless = np.array([np.full(N, np.inf), np.random.default_rng(0).standard_normal(N)])
    (seen,) = inner(endless[None], on.absorbed, on.residual)
    (alone,) = inner(endless[None, 1:], on.absorbed, on.residual)
    assert seen.drop == pytest.approx(alone.drop)
    np.testing.assert_allclose(seen.sizes, [0.0, alone.sizes[0]])


def test_what_the_model_can_do_itself_has_no_size() -> None:
    """Rounding had: the axial force of residual stress was 10⁸ N/V beside a stiffness that a voltage changes."""
    on, rng = bench(5, 2), np.random.default_rng(6)
    own = rng.standard_normal(N)
    rows = np.array([on.absorbed.T[0] + 1e-9 * rng.standard_normal(N), own])
    (seen,) = inner(rows[None], on.absorbed, on.residual)
    (alone,) = inner(own[None, None], on.absorbed, on.residual)
    np.testing.assert_allclose(seen.sizes, [0.0, alone.sizes[0]])


def test_rows_at_zero_leave_what_the_others_say() -> None:
    on, rng = bench(8, 3), np.random.default_rng(9)
    rows = rng.standard_normal((3, N))
    (seen,) = inner(rows[None], on.absorbed, on.residual)
    (alone,) = inner(rows[None, [0, 2]], on.absorbed, on.residual)
    without = seen.without(np.array([False, True, False]))
    assert without.drop == pytest.approx(alone.drop)
    np.testing.assert_allclose(without.sizes, [alone.sizes[0], 0.0, alone.sizes[1]])


def test_histories_that_suit_are_found_without_the_columns() -> None:
    """Rows with the histories that are found have the inner products that are told, and explain what they made."""
    on, rng = bench(5, 3), np.random.default_rng(6)
    raw, changes = rng.standard_normal((2, N)), rng.standard_normal((3, 2, N))
    spans = (slice(0, 80), slice(120, N))
    histories, own = Histories(changes, spans), slice(0, 2)
    truth = rng.standard_normal((2, 3))
    made = histories.added(raw, truth, own)
    on.residual = on.project(np.array([[30.0, -20.0]]) @ made)[0]
    past, seen, price = histories.fitted(on, raw, own)  # type: ignore[arg-type]
    (there,) = inner(histories.added(raw, past, own)[None], on.absorbed, on.residual)
    for told, of_columns in zip(seen, there, strict=True):
        np.testing.assert_allclose(told, of_columns, rtol=1e-9, atol=1e-7)
    assert price > 0 and seen.drop is not None
    assert seen.drop > 0.99 * float(on.residual @ on.residual)
    np.testing.assert_allclose(past, truth, atol=0.1)
