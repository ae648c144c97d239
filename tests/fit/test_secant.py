"""The curvature that Gauss–Newton leaves out, learned from steps."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ident.fit.normal import Normal
from ident.fit.secant import Secant

OFF = 3.0  # that the law of the second residual lacks


def _residuals(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Along a valley that bends, next to nothing of which the first slope foretells; (3,) and its Jacobian (3, 2)."""
    r = np.array([10 * (x[1] - x[0] ** 2), OFF + 0.5 * x[0] ** 2, 0.1 * (x[0] - 1)])
    return r, np.array([[-20 * x[0], 10.0], [x[0], 0.0], [0.1, 0.0]])


def _normal(x: np.ndarray) -> Normal:
    r, jacobian = _residuals(x)
    return Normal(0.5 * r @ r, jacobian.T @ r, jacobian.T @ jacobian)


def _learned(secant: Secant, before: np.ndarray, after: np.ndarray) -> Secant:
    r, now = _residuals(after)
    return secant.learn(after - before, _normal(before), _normal(after), now.T @ r - _residuals(before)[1].T @ r, True)


@given(st.lists(st.integers(-40, 40), min_size=6, max_size=6))
def test_along_its_last_step_it_tells_how_the_slope_has_turned(at: list[int]) -> None:
    points, secant = np.reshape(at, (3, 2)) / 20, Secant(np.zeros((2, 2)))
    for before, after in zip(points[:-1], points[1:], strict=True):
        old, secant = secant, _learned(secant, before, after)
        step, r = after - before, _residuals(after)[0]
        turned = (_residuals(after)[1] - _residuals(before)[1]).T @ r
        if secant.matrix is not old.matrix:
            scale = np.linalg.norm(secant.matrix) * np.linalg.norm(step) + np.linalg.norm(turned)
            np.testing.assert_allclose(secant.matrix @ step, turned, atol=1e-6 * scale)
        np.testing.assert_allclose(secant.matrix, secant.matrix.T, atol=1e-9 * np.abs(secant.matrix).max(initial=1e-9))
        assert np.all(np.linalg.eigvalsh(secant._replace(use=True).bend(_normal(after), np.ones(2)).matrix) >= -1e-9)


def test_a_bent_valley_is_left_in_fewer_steps() -> None:
    """Newton steps of both models, halved until they help, from the same start to the same minimum."""
    steps = {}
    for learns in (False, True):
        x, secant, taken = np.array([1.5, 2.0]), Secant(np.zeros((2, 2))), 0
        while np.linalg.norm(_normal(x).gradient) > 1e-6 and taken < 1000:
            here = secant.bend(_normal(x), np.ones(2))
            move = -np.linalg.solve(here.matrix, here.gradient)
            while _normal(x + move).cost > here.cost:
                move, taken = move / 2, taken + 1
            secant = _learned(secant, x, x + move) if learns else secant
            x, taken = x + move, taken + 1
        steps[learns] = taken
    assert 3 * steps[True] < steps[False]


def test_a_trial_without_bound_tells_nothing() -> None:
    here, secant = _normal(np.ones(2)), Secant(np.eye(2), use=True, proven=True)
    lost = Normal(np.array(np.inf), np.full(2, np.nan), np.full((2, 2), np.nan))
    after = secant.learn(np.ones(2), here, lost, np.full(2, np.nan), True)
    assert after.matrix is secant.matrix and after.use and not after.proven
    assert secant.bend(lost, np.ones(2)) is lost
    far = Normal(np.array(1e300), np.full(2, 1e200), np.eye(2))
    assert np.all(np.isfinite(secant.learn(np.full(2, 1e-200), here, far, np.full(2, 1e200), True).matrix))
