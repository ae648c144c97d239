"""`ident sample`, `compare` and `attribute` on the paper's campaign, shortened."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

from tests.end_to_end.user import DATA, assert_one_line, ident

for package in ("h5py", "arviz_base", "h5netcdf"):
    pytest.importorskip(package)

KEPT = ("sine_8V_317Hz.csv", "sine_9V_510Hz.csv", "sine_5V_450Hz.csv")
SAMPLES = 1600
TRUTH = {"platform.frequency": 498.6, "platform.quality": 31.0, "platform.d31": 6.4e-11, "pzt-hysteresis.eta": 2.2e-23,
         "pzt-hysteresis.zeta": 1.7e-23, "residual-stress.restraint": 0.38}  # fmt: skip


@pytest.fixture(scope="module")
def home(tmp_path_factory) -> Path:
    """`campaign/` with three records of the paper's campaign, cut short; runs of three models beside it."""
    home = tmp_path_factory.mktemp("posterior")
    (home / "campaign").mkdir()
    for name in KEPT:
        lines = (DATA / "platform_317hz" / name).read_text(encoding="utf-8").splitlines(keepends=True)
        (home / "campaign" / name).write_text("".join(lines[: SAMPLES + 1]), encoding="utf-8")
    whole = (DATA / "platform_317hz" / "campaign.toml").read_text(encoding="utf-8")
    head, *blocks = whole.split("[[record]]")
    kept = [block for block in blocks if any(f'"{name}"' in block for name in KEPT)]
    (home / "campaign" / "campaign.toml").write_text("[[record]]".join([head, *kept]), encoding="utf-8")
    assert ident("fit", home / "campaign", "-o", home / "both").code == 0
    return home


@pytest.fixture(scope="module")
def sampled(home) -> dict:
    outcome = ident("sample", home / "both", "--json")
    assert outcome.code == 0, outcome.err
    assert "effective draws" in outcome.err and "s left" in outcome.err
    return json.loads(outcome.out)


def test_sample_says_what_it_found_in_numbers(home, sampled):
    assert sampled == json.loads((home / "both" / "posterior.json").read_text(encoding="utf-8"))
    assert sampled["format"] == 1 and sampled["trusted"] is True and sampled["reasons"] == []
    assert sampled["ess_min"] > 1000 and sampled["rhat_max"] < 1.01
    found = {p["name"]: p for p in sampled["parameters"]}
    for name, value in TRUTH.items():
        assert abs(found[name]["mean"] - value) < 4.5 * found[name]["sd"], name
        assert found[name]["interval90"][0] < found[name]["mean"] < found[name]["interval90"][1]
    # One combination of the stresses reaches the displacement: what tells them apart is the prior, and that is said.
    assert found["residual-stress.sigma12"]["prior_decides"] and found["residual-stress.sigma23"]["prior_decides"]
    assert not found["platform.frequency"]["prior_decides"]
    assert sampled["log_evidence"]["pareto_k"] < 0.7
    assert sampled["log_evidence"]["value"] == pytest.approx(sampled["log_evidence"]["laplace"], abs=0.5)


def test_sample_leaves_a_container_a_chain_and_a_page(home, sampled):
    import emcee
    import h5py

    with h5py.File(home / "both" / "posterior.nc") as file:
        assert {"posterior", "log_likelihood", "posterior_predictive", "observed_data"} <= set(file)
        frequency = file["posterior"]["platform.frequency"]
        assert frequency.shape[0] == sampled["ensembles"]
        told = next(p for p in sampled["parameters"] if p["name"] == "platform.frequency")
        assert np.mean(frequency[()]) == pytest.approx(told["mean"], abs=5 * told["sd"] / 20)
        assert file["observed_data"]["sine_8V_317Hz"].shape[0] > 0.99 * SAMPLES
        spread = np.std(file["posterior_predictive"]["sine_8V_317Hz"][()] - file["observed_data"]["sine_8V_317Hz"][()])
        assert spread == pytest.approx(np.sqrt(2) * 30e-9, rel=0.1)  # noise of the data and of the prediction
    chain = emcee.backends.HDFBackend(str(home / "both" / "chain.h5"), name="ensemble_0", read_only=True).get_chain()
    assert chain.shape[2] == len(sampled["parameters"])
    page = (home / "both" / "report.html").read_text(encoding="utf-8")
    assert "<h2>Posterior" in page or "Posterior" in page
    assert (home / "both" / "figures" / "posterior.png").stat().st_size > 10_000


def test_the_snippet_of_the_documents_draws_a_band_over_data(home, sampled, tmp_path):
    page = (DATA.parent / "docs" / "posterior.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    code = code.replace("runs/paper", str(home / "both")).replace("band.png", str(tmp_path / "band.png"))
    environment = {**os.environ, "MPLBACKEND": "agg"}
    script = f"{code}\nprint(float(time[0]), float(time[-1]), float(((data > low) & (data < high)).mean()))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    first, last, inside = map(float, done.stdout.split())
    record = np.loadtxt(home / "campaign" / "sine_8V_317Hz.csv", delimiter=",", skiprows=2)[:, 0]  # Time_ms
    assert (first, last) == pytest.approx((record[0], record[-1]), rel=1e-4, abs=1e-6)
    assert 0.8 < inside < 0.95
    assert (tmp_path / "band.png").stat().st_size > 5000


def test_arviz_reads_the_container(home, sampled):
    """With ArviZ beside the project: `.ci/run` has the oldest that is promised."""
    with warnings.catch_warnings(action="ignore"):  # of its own future
        arviz = pytest.importorskip("arviz")
        table = arviz.summary(arviz.from_netcdf(home / "both" / "posterior.nc"), round_to="none")
    told = next(p for p in sampled["parameters"] if p["name"] == "platform.quality")
    assert table.loc["platform.quality", "mean"] == pytest.approx(told["mean"], abs=0.2 * told["sd"])
    assert table.loc["platform.quality", "r_hat"] < 1.02


def test_sample_goes_on_only_where_it_is_told_to(home, sampled):
    assert_one_line(ident("sample", home / "both"), "has a chain already", "--resume")
    before = (home / "both" / "chain.h5").read_bytes()
    assert ident("sample", home / "both", "--resume").code == 0  # it was done: nothing is drawn
    import h5py

    with h5py.File(home / "both" / "chain.h5") as file:
        assert file["ensemble_0"].attrs["iteration"] == sampled["steps"] + sampled["burn_in"]
    (home / "both" / "chain.h5").write_bytes(before[: len(before) // 2])
    assert_one_line(ident("sample", home / "both", "--resume"), "cut short")
    (home / "both" / "chain.h5").write_bytes(before)


def test_attribute_names_residual_stress_and_report_keeps_both_parts(home, sampled):
    outcome = ident("attribute", home / "both", "--json")
    assert outcome.code == 0, outcome.err
    document = json.loads(outcome.out)
    assert document["format"] == 1 and document["verdict"] == "one mechanism"
    assert document["leading"] == ["residual-stress"]
    assert {s["mechanism"]: round(s["share"], 1) for s in document["overall"]}["residual-stress"] == 1.0
    record = next(r for r in document["records"] if r["file"] == "sine_8V_317Hz.csv")
    mean = next(m for m in record["measures"] if m["measure"] == "mean over periods")
    assert mean["unit"] == "um" and -0.2 < mean["data"] < -0.05
    assert sum(s["share"] for s in mean["shares"]) == pytest.approx(1.0, abs=0.01)
    assert ident("report", home / "both").code == 0
    page = (home / "both" / "report.html").read_text(encoding="utf-8")
    assert "What explains the zero-point offset" in page and "The intervals are final" in page


def test_compare_decides_for_the_model_that_made_the_records(home, tmp_path):
    for effects in ("residual-stress", "residual-stress,pzt-hysteresis,electrostriction"):
        assert ident("fit", home / "campaign", "--effects", effects, "-o", home / effects).code == 0
    runs = [home / name for name in ("both", "residual-stress", "residual-stress,pzt-hysteresis,electrostriction")]
    outcome = ident("compare", *runs, "-o", tmp_path / "compared", "--json")
    assert outcome.code == 0, outcome.err
    document = json.loads(outcome.out)
    assert document == json.loads((tmp_path / "compared" / "compare.json").read_text(encoding="utf-8"))
    assert document["best"] == str(runs[0]) and document["verdict"] == "decided"
    assert sum(m["probability"] for m in document["models"]) == pytest.approx(1.0)
    assert [m["describes_the_records"] for m in document["models"]] == [True, False, True]
    assert (tmp_path / "compared" / "compare.png").stat().st_size > 5000
    assert_one_line(ident("compare", runs[0]), "nothing to be compared with")
    assert_one_line(ident("compare", *runs, "-o", tmp_path / "compared"), "exists already")
