"""Evidence against closed forms: regressions, records that begin in motion, two peaks, a badly placed proposal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy import stats
from scipy.special import logsumexp

from ident.campaign.campaign import Prior
from ident.fit.fit import fit
from ident.model import build_model
from ident.posterior import compare as comparison
from ident.posterior import density as densities
from ident.posterior.bent import fit_bent
from ident.posterior.density import make_density
from ident.posterior.evidence import log_evidence
from ident.posterior.laplace import Laplace, find_peak
from ident.posterior.mixture import fit_mixture
from ident.posterior.pareto import smooth
from ident.report.compare_view import compare_dict, compare_figure, compare_sheet
from tests.posterior.records import SIGMA, campaign, record

HELD = {"oscillator": {"frequency": 71.3, "quality": 14.0, "fixed": ("frequency", "quality")}}
PRIOR = Prior(1.5e5, 4e4)


@dataclass(frozen=True)
class Known:
    """A density whose integral is known."""

    size: int
    log_posterior: object


def linear_fit(*records):
    data = campaign(*records, priors={"oscillator.gain": PRIOR}, **HELD)
    return fit(build_model(data, ()), data)


@pytest.mark.parametrize("memory", [0.0, 0.6])
def test_of_a_linear_regression(memory):
    """y = g φ + noise with g ~ N: ln Z is a multivariate normal density (given the first sample, if it is coloured)."""
    from experiments.simulator.circuit import Circuit

    linear = Circuit(71.3, 14.0, 1.9e5, 0.0)
    found = linear_fit(record(1, linear, samples=300, memory=memory))
    (trace,) = found.campaign.fitted
    unit = found.readings[0] / found.value("oscillator.gain")
    n = len(unit)
    innovations = np.eye(n)[1:] - memory * np.eye(n)[:-1] if memory else np.eye(n)
    y, phi = innovations @ trace.response, innovations @ unit
    covariance = SIGMA**2 * (1 - memory**2) * np.eye(len(y)) + PRIOR.deviation**2 * np.outer(phi, phi)
    exact = stats.multivariate_normal(PRIOR.mean * phi, covariance).logpdf(y)

    evidence = log_evidence(found)

    assert evidence.trusted and evidence.efficiency > 0.8
    assert evidence.value == pytest.approx(exact, abs=4 * evidence.error + 0.01)
    assert evidence.laplace == pytest.approx(exact, abs=0.01)
    drawn = evidence.density.values(evidence.resampled(4000))[:, 2]
    inverse = phi @ phi / (SIGMA**2 * (1 - memory**2)) + PRIOR.deviation**-2
    assert drawn.std() == pytest.approx(inverse**-0.5, rel=0.05)


def test_initial_states_are_integrated_out_exactly_where_the_motion_is_linear():
    from experiments.simulator.circuit import Circuit

    linear = Circuit(71.3, 14.0, 1.9e5, 0.0)
    found = linear_fit(record(2, linear, samples=250, lead=150))
    density = make_density(found)
    (trace,) = found.campaign.fitted
    # The free motion by its formula, not by the solver.
    w0, decay = 2 * np.pi * 71.3, np.pi * 71.3 / 14.0
    w = np.sqrt(w0**2 - decay**2)
    t, fade = trace.time, np.exp(-decay * trace.time)
    free = np.stack([fade * (np.cos(w * t) + decay / w * np.sin(w * t)), fade * np.sin(w * t) / w], axis=1)
    free = free * density.data.start_scale[0]
    values = found.values[None].repeat(3, axis=0)
    values[:, 2] *= np.array([0.99, 1.0, 1.02])
    x = (values[:, 2] - density.data.anchor)[:, None] / density.data.scale
    _, likelihood = density.parts(x)
    start = density.starts[0]
    for k in range(3):
        forced = density.readings(values[k : k + 1])[0][0] - free @ start
        covariance = SIGMA**2 * np.eye(len(t)) + free @ free.T
        exact = stats.multivariate_normal(forced, covariance).logpdf(trace.response)
        assert likelihood[k, 0] == pytest.approx(exact, abs=0.02)


def gaussian_mixture(x: np.ndarray) -> np.ndarray:
    """Two peaks eight standard deviations apart, integral 1."""
    ends = [stats.multivariate_normal([at, 0.0, 0.0]).logpdf(x) for at in (-4.0, 4.0)]
    return np.logaddexp(*ends) - np.log(2)


def bridge(laplace: Laplace, draws: np.ndarray) -> tuple[float, float]:
    """ln Z and its standard error by bridge sampling, a check that shares only the density with `log_evidence`.

    One half of the posterior `draws` (k, p) gives the proposal, the other meets draws from it half way.

    Source: X.-L. Meng, W. H. Wong, Statistica Sinica 6 (1996) 831.
    """
    random = np.random.default_rng([0, 2])
    chosen, used = draws[::2], draws[1::2]
    target = fit_bent(chosen)
    fresh = target.draw(random, len(used))
    ratio = lambda x: laplace.density.log_posterior(x) - target.log_density(x)
    of_posterior, of_proposal = ratio(used), ratio(fresh)
    effective = len(used)
    share = np.log(effective / (effective + len(fresh))), np.log(len(fresh) / (effective + len(fresh)))
    value = float(np.median(of_posterior))
    for _ in range(1000):
        upper = of_proposal - np.logaddexp(share[0] + of_proposal, share[1] + value)
        lower = -np.logaddexp(share[0] + of_posterior, share[1] + value)
        new = float(logsumexp(upper) - np.log(len(upper)) - logsumexp(lower) + np.log(len(lower)))
        if abs(new - value) < 1e-9:
            break
        value = new
    spread = lambda logs: float(np.var(np.exp(logs - logsumexp(logs) + np.log(len(logs)))))
    error = np.sqrt(spread(upper) / len(upper) + spread(lower) / effective)
    return value, float(error)


def test_where_one_peak_does_not_describe_the_posterior_a_mixture_on_draws_does():
    random = np.random.default_rng(0)
    draws = random.standard_normal((4000, 3))
    draws[:, 0] += random.choice([-4.0, 4.0], 4000)
    known = Known(3, gaussian_mixture)
    at_one_peak = Laplace(known, 0.0, np.diag([1.0, 1.0, 1.0]))  # type: ignore[arg-type]
    found = log_evidence(at_one_peak, draws)
    assert "mixture" in found.method
    assert found.trusted and abs(found.value) < 4 * found.error + 0.02
    value, error = bridge(at_one_peak, draws)
    assert abs(value) < 4 * error + 0.02 and error < 0.05


def test_weights_that_cannot_be_trusted_say_so():
    """A proposal a third as wide as its target."""
    target = lambda x: stats.t(2).logpdf(x).sum(axis=1)
    narrow = Laplace(Known(6, target), 0.0, 0.02 * np.eye(6))  # type: ignore[arg-type]
    found = log_evidence(narrow, count=1024, draws=np.random.default_rng(0).normal(0, 0.2, (500, 6)))
    assert not found.trusted and "not to be trusted" in found.words


def test_pareto_shape_is_that_of_the_tail():
    random = np.random.default_rng(4)
    for shape in (0.2, 0.5, 0.9):
        found = np.mean([smooth(np.log(stats.genpareto(shape).rvs(4000, random_state=random))).shape for _ in range(8)])
        assert found == pytest.approx(shape, abs=0.12)
    assert smooth(np.zeros(1000)).shape < 0
    smoothed = smooth(random.normal(size=2000))
    assert np.exp(smoothed.log_weights).sum() == pytest.approx(1.0)


def test_a_mixture_covers_the_draws_it_was_fitted_to():
    random = np.random.default_rng(5)
    draws = np.concatenate([random.normal(-4, 1, (1500, 2)), random.normal(4, 0.5, (1500, 2))])
    mixture = fit_mixture(draws)
    fresh = mixture.draw(random, 20_000)
    assert np.mean(fresh[:, 0] > 0) == pytest.approx(0.5, abs=0.05)
    density = np.exp(mixture.log_density(fresh))
    assert np.all(density > 0)
    box = (np.abs(fresh) < 2).all(axis=1)  # hardly anything lies between the two
    assert box.mean() < 0.1


def test_the_peak_is_where_the_density_is_largest():
    found = linear_fit(record(3, samples=300))
    laplace = find_peak(make_density(found))
    steps = np.linspace(-0.2, 0.2, 41)[:, None] * np.sqrt(laplace.covariance[0, 0])
    around = laplace.density.log_posterior(steps)
    assert around.max() - laplace.peak < 1e-4


@pytest.mark.parametrize("gone", [{"b"}, {"a", "b"}])
def test_a_model_without_evidence_is_told_of_and_decides_nothing(gone, monkeypatch):
    """ln Z = −∞: none of its draws allows the records."""
    one, other = linear_fit(record(1, samples=300)), linear_fit(record(1, samples=300))
    lost = {id(fit) for name, fit in (("a", one), ("b", other)) if name in gone}

    def evidence(fit):
        found = log_evidence(fit)
        return found._replace(value=-np.inf, shape=np.inf) if id(fit) in lost else found

    monkeypatch.setattr(comparison, "log_evidence", evidence)
    found = comparison.compare([("b", other), ("a", one)])
    assert f"No evidence was found of {', '.join(sorted(gone, reverse=True))}" in found.words
    assert found.verdict == "undecided" and np.isnan(found.lead) and "prefer" not in found.words
    assert found.models[1].probability == 1.0 if gone == {"b"} else np.isnan(found.models[1].probability)
    assert found.best == (1 if gone == {"b"} else 0)
    assert "no evidence" in evidence(other).words
    sheet = compare_sheet(compare_dict(found))
    assert sheet.rows[-1][2] == "–" and "no evidence" in sheet.rows[-1][-1]
    assert np.isfinite(compare_figure(compare_dict(found)).axes[0].get_xlim()).all()


def test_a_density_over_other_records_keeps_coordinates_and_priors_and_is_put_together_once(monkeypatch):
    base = make_density(linear_fit(record(1, samples=300), record(2, samples=300, holdout=True)))
    base, put_together = base.moved(np.full(base.size, 0.3)), []
    real = densities.assemble
    monkeypatch.setattr(densities, "assemble", lambda *given: put_together.append(1) or real(*given))
    other = base.over(base.fit.campaign.heldout)
    assert len(put_together) == 1 and other.priors is base.priors and [r.name for r in other.records] == ["2.csv"]
    x = np.random.default_rng(0).standard_normal((3, base.size))
    np.testing.assert_array_equal(other.values(x), base.values(x))
