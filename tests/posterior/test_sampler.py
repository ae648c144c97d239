"""A chain that is interrupted, killed or moved: it goes on bit by bit, or is refused in one line."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import emcee
import numpy as np
import pytest

from ident.campaign.campaign import Prior
from ident.errors import UserError
from ident.fit.fit import fit
from ident.model import build_model
from ident.posterior import sampler
from ident.posterior.chain_file import read_chain
from ident.posterior.density import make_density
from ident.posterior.misfit import misfit, too_narrow
from ident.posterior.result import chain_draws, draw_posterior, run_key
from tests.posterior.records import campaign, record

ROOT = Path(__file__).parent.parent.parent
h5py = pytest.importorskip("h5py")


def small_fit(memory: float = 0.0, effects: tuple[str, ...] = ("cubic-stiffness",), **changed):
    data = campaign(record(1, samples=300, memory=memory, **changed), record(2, samples=300, memory=memory, **changed),
                    priors={"oscillator.frequency": Prior(70.0, 5.0)})  # fmt: skip
    return fit(build_model(data, effects), data)


@pytest.fixture(scope="module")
def found():
    return small_fit()


@pytest.fixture(scope="module")
def undisturbed(found, tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "chain.h5"
    return path, draw_posterior(found, path)


def test_the_posterior_is_final_and_where_the_truth_is(undisturbed):
    _, posterior = undisturbed
    assert posterior.trusted, posterior.reasons
    truth = {
        "oscillator.frequency": 71.3,
        "oscillator.quality": 14.0,
        "oscillator.gain": 1.9e5,
        "cubic-stiffness.k3": 6e4,
    }
    for marginal in posterior.marginals:
        assert abs(marginal.mean - truth[marginal.prior.name]) < 4 * marginal.deviation
        assert marginal.low < marginal.median < marginal.high and not marginal.prior_decides
    # Beside a sharp likelihood the posterior is that of the regression.
    errors = [e.standard_error for e in posterior.fit.estimates if e.fitted]
    assert [m.deviation for m in posterior.marginals] == pytest.approx(errors, rel=0.06)


def test_a_chain_interrupted_at_every_look_goes_on_bit_by_bit(found, undisturbed, tmp_path):
    path, whole = undisturbed
    density, key = make_density(found), run_key(make_density(found), 0)
    partial, looks = tmp_path / "chain.h5", []

    def stop(now: sampler.Progress) -> None:
        """At a look that was not there before: a resumed chain begins with the one that it was stopped at."""
        if now.steps not in looks:
            looks.append(now.steps)
            raise KeyboardInterrupt

    resumed = sampler.sample(density, partial, key, report=stop)
    assert resumed.stopped == "it was interrupted" and resumed.convergence.reasons
    while resumed.stopped:
        resumed = sampler.sample(density, partial, key, resume=True, report=stop)
    assert len(looks) >= 3
    assert np.array_equal(resumed.chain.positions, whole.sampled.chain.positions)
    assert np.array_equal(resumed.chain.log_probability, whole.sampled.chain.log_probability)
    assert resumed.chain.taus == whole.sampled.chain.taus


def test_proposals_that_miss_most_of_the_posterior_are_learned_anew(found, undisturbed, tmp_path, monkeypatch):
    """They come from a tenth of its width. What was drawn with them is left out, and a resumed chain does the same."""
    _, whole = undisturbed
    density, key, learned = make_density(found), run_key(make_density(found), 0), sampler.learned

    def narrow(laplace, count, seed=0):
        return 0.1 * np.random.default_rng(seed).multivariate_normal(np.zeros(density.size), laplace.covariance, count)

    monkeypatch.setattr(sampler, "learned", narrow)
    told: list[int] = []
    anew = sampler.sample(density, None, key, report=lambda now: told.append(now.steps))
    assert anew.chain.frame["learned"] >= 1
    assert told[told.index(300) + 1] < 300 and not anew.convergence.reasons
    here, there = (sampled.kept.reshape(-1, density.size) for sampled in (anew, whole.sampled))
    np.testing.assert_allclose(here.mean(axis=0), there.mean(axis=0), atol=0.1 * float(np.min(there.std(axis=0))))
    np.testing.assert_allclose(here.std(axis=0), there.std(axis=0), rtol=0.1)

    def stop(now: sampler.Progress) -> None:
        if now.steps == 300:
            raise KeyboardInterrupt

    sampler.sample(density, tmp_path / "chain.h5", key, report=stop)
    with monkeypatch.context() as patch:
        patch.setattr(sampler, "learned", learned)  # nothing is learned from what is not there any more
        resumed = sampler.sample(density, tmp_path / "chain.h5", key, resume=True)
    assert np.array_equal(resumed.chain.positions, anew.chain.positions)

    block = sampler._block

    def interrupted(samplers, chain):
        if int(chain.frame.get("learned", 0)):
            raise KeyboardInterrupt
        return block(samplers, chain)

    monkeypatch.setattr(sampler, "_block", interrupted)  # before the new chain has been looked at
    cut = sampler.sample(density, None, key)
    assert cut.stopped == "it was interrupted" and cut.convergence.reasons and len(cut.draws(8)) == 8


def test_emcee_reads_every_ensemble(undisturbed):
    path, posterior = undisturbed
    for e in range(sampler.ENSEMBLES):
        backend = emcee.backends.HDFBackend(str(path), name=f"ensemble_{e}", read_only=True)
        assert np.array_equal(backend.get_chain(), posterior.sampled.chain.positions[e])


def test_a_chain_that_is_damaged_cut_short_or_anothers_is_refused(undisturbed, tmp_path):
    path, posterior = undisturbed
    key = run_key(posterior.density, 0)
    whole = path.read_bytes()
    broken = tmp_path / "chain.h5"
    with pytest.raises(UserError, match="no chain to go on with"):
        read_chain(broken, key)
    for size in (0, 100, len(whole) // 2, len(whole) - 200):
        broken.write_bytes(whole[:size])
        with pytest.raises(UserError, match="cut short or damaged"):
            read_chain(broken, key)
    damaged = bytearray(whole)
    for at in range(len(whole) // 3, 2 * len(whole) // 3, 997):
        damaged[at] ^= 0xFF
    broken.write_bytes(bytes(damaged))
    with pytest.raises(UserError, match="cut short or damaged"):
        read_chain(broken, key)
    with pytest.raises(UserError, match="belongs to another run"):
        read_chain(path, run_key(posterior.density, 1))


def test_a_chain_is_anothers_where_the_drive_is_held_otherwise_or_the_equation_of_motion_is_another(found):
    density = make_density(found)
    first, *rest = density.records

    def read_so(**changed):
        return replace(density, records=(replace(first, **changed), *rest))

    shaken = replace(density, fit=replace(found, model=replace(found.model, form="shaken")))
    others = [read_so(edge=0.0), read_so(edge=0.5), read_so(measures="velocity"), shaken]
    assert len({run_key(one, 0) for one in (density, *others)}) == 5
    assert run_key(replace(density), 0) == run_key(density, 0)


def test_the_draws_of_a_finished_chain_serve_its_own_fit_alone(found, undisturbed, tmp_path):
    path, posterior = undisturbed
    draws = chain_draws(found, path, 200)
    assert draws is not None and draws.shape == (200, len(found.values))
    free = list(posterior.density.static.free)
    middle = [m.mean for m in posterior.marginals]
    assert np.allclose(draws[:, free].mean(axis=0), middle, atol=0.3 * draws[:, free].std(axis=0), rtol=0)
    assert chain_draws(found, tmp_path / "none.h5", 200) is None
    assert chain_draws(replace(found, sigma="scaled"), path, 200) is None


KILLED = """
import sys
from pathlib import Path
from ident.posterior import sampler
from ident.posterior.density import make_density
from ident.posterior.result import run_key
from tests.posterior.test_sampler import small_fit
sampler._EVERY = 0.0
density = make_density(small_fit())
path = Path(sys.argv[1])
done = sampler.sample(density, path, run_key(density, 0), resume=path.exists())
assert not done.stopped
"""


@pytest.mark.slow
def test_a_killed_chain_goes_on_bit_by_bit(undisturbed, tmp_path):
    _, whole = undisturbed
    path = tmp_path / "chain.h5"
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    random = np.random.default_rng()
    kills = 0
    for attempt in range(40):
        process = subprocess.Popen([sys.executable, "-c", KILLED, str(path)], env=environment, cwd=ROOT)
        before = path.stat().st_mtime_ns if path.exists() else 0
        while attempt < 6 and process.poll() is None and (not path.exists() or path.stat().st_mtime_ns == before):
            time.sleep(0.005)
        if (
            attempt < 6 and process.poll() is None
        ):  # the first blocks are being drawn and written: strike somewhere there
            time.sleep(float(random.uniform(0.0, 0.3)))
            process.send_signal(signal.SIGKILL)
            kills += process.wait() == -signal.SIGKILL
            continue
        assert process.wait() == 0
        break
    assert kills >= 1
    resumed = read_chain(path, run_key(make_density(small_fit()), 0))
    assert np.array_equal(resumed.positions, whole.sampled.chain.positions)


def test_a_model_that_misses_something_refuses_final_intervals(tmp_path):
    """Without its cubic spring the model cannot describe the records, and a good model of the same records does."""
    lacking = draw_posterior(small_fit(effects=()), tmp_path / "chain.h5")
    assert not lacking.trusted
    assert any("ident diagnose" in reason for reason in lacking.reasons)


def test_coloured_noise_widens_the_intervals_and_is_no_misfit():
    from ident.posterior.laplace import find_peak

    coloured = find_peak(make_density(small_fit(memory=0.8))).density
    assert misfit(coloured).reasons == ()
    assert too_narrow(coloured) > 1.2
    assert too_narrow(make_density(small_fit())) == 1.0


def test_time_that_runs_out_leaves_intervals_that_are_not_final(found, tmp_path):
    posterior = draw_posterior(found, tmp_path / "chain.h5", seconds=1e-9)
    assert posterior.reasons[0] == "time ran out" and not posterior.trusted
