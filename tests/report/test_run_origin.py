"""What may change in a campaign without touching the runs that were made of it, and what may not."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lsim

import ident
from ident.campaign.noise.hum import HUMS
from ident.campaign.trust import trust
from ident.errors import UserError
from ident.report.run_folder import load_run, read_run
from ident.report.run_origin import campaign_of

CAMPAIGN = """\
title = "two sines"
device = { kind = "oscillator", output = "V", input = "V" }

[model]
effects = []

[effect.cubic-stiffness]
k3 = 2.0

[effect.coulomb-friction]
fixed = ["velocity"]

[[record]]
file = "a.csv"
start = "rest"
noise = "12 mV"

[[record]]
file = "b.csv"
start = "rest"
skip = "2 ms"
"""
OWN = '''
from ident.effects import AbstractEffect, amplitude


class MySpring(AbstractEffect):
    """F = −k z."""

    name = "my-spring"
    k = amplitude("N/m^3", "cubic stiffness", default=1.0)

    def force(self, state, drive, t):
        return -self.k * state.z**3
'''


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign with two short records and two runs of it, one with an effect of the user's own."""
    folder, rng = tmp_path_factory.mktemp("lab"), np.random.default_rng(3)
    t, omega = np.arange(300) / 3000, 2 * np.pi * 100
    for name, f in (("a", 90.0), ("b", 112.0)):
        u = np.sin(2 * np.pi * f * t)
        z = lsim(([omega**2], [1, omega / 15, omega**2]), u, t)[1] + 0.012 * rng.standard_normal(len(t))
        rows = "".join(f"{x:.6f},{a:.6f},{b:.6f}\n" for x, a, b in zip(t, u, z, strict=True))
        (folder / f"{name}.csv").write_text(f"time (s),drive (V),response (V)\n{rows}", encoding="utf-8")
    (folder / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    (folder / "my_effect.py").write_text(OWN, encoding="utf-8")
    ident.write_run(ident.fit(folder), folder / "run", page=False)
    trust(folder / "my_effect.py")
    named = 'effects = ["my-spring"]\neffect_files = ["my_effect.py"]'
    (folder / "own.toml").write_text(CAMPAIGN.replace("effects = []", named), encoding="utf-8")
    ident.write_run(ident.fit(folder / "own.toml"), folder / "own", page=False)
    return folder


def loads(lab: Path, text: str, run: str = "run", name: str = "campaign.toml"):
    """The campaign of a run where its file says this."""
    before = (lab / name).read_text(encoding="utf-8")
    (lab / name).write_text(text, encoding="utf-8")
    try:
        return campaign_of(read_run(lab / run), lab / run)
    finally:
        (lab / name).write_text(before, encoding="utf-8")


HEAD, *RECORDS = CAMPAIGN.split("[[record]]\n")


@pytest.mark.parametrize(
    "text",
    [
        "# a comment\n" + CAMPAIGN.replace('start = "rest"', 'start = "rest"   # was still'),
        CAMPAIGN.replace('start = "rest"\nnoise = "12 mV"', 'noise = "0.012 V"\nholdout = false\nstart = "rest"'),
        CAMPAIGN.replace("two sines", "my two sines"),
        CAMPAIGN.replace("effects = []", 'effects = ["cubic-stiffness"]'),
        CAMPAIGN.replace("effects = []", 'effects = ["my-spring"]\neffect_files = ["my_effect.py"]'),
        CAMPAIGN.replace("k3 = 2.0", "k3 = 3.0"),  # the run has no such effect
        re.sub(r'start = "rest"\n', "", CAMPAIGN).replace("[model]", '[defaults]\nstart = "rest"\n[model]'),
        CAMPAIGN + '[priors]\n"oscillator.quality" = { normal = [15, 3] }\n',
    ],
)
def test_what_the_run_does_not_depend_on_may_change(lab, text):
    assert text != CAMPAIGN
    assert [record.name for record in loads(lab, text).records] == ["a.csv", "b.csv"]


def nearly(told):
    if isinstance(told, dict):
        return {name: nearly(value) for name, value in told.items()}
    if isinstance(told, list):
        return [nearly(value) for value in told]
    return pytest.approx(told, rel=1e-9) if isinstance(told, float) else told


def test_records_that_change_their_order_keep_what_the_run_found_of_them(lab):
    turned = HEAD + "[[record]]\n" + RECORDS[1] + "\n[[record]]\n" + RECORDS[0]
    assert [record.name for record in loads(lab, turned).records] == ["a.csv", "b.csv"]
    (lab / "campaign.toml").write_text(turned, encoding="utf-8")
    fit = load_run(lab / "run")
    assert [record.name for record in fit.campaign.records] == ["a.csv", "b.csv"]
    again = ident.write_run(fit, lab / "again", page=False)
    (lab / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    # Another order of the sums, another rounding.
    assert read_run(again)["records"] == nearly(read_run(lab / "run")["records"])
    assert load_run(again).fitted.error_over_noise == pytest.approx(fit.fitted.error_over_noise, rel=1e-6)


@pytest.mark.parametrize(
    ("part", "instead", "says"),
    [
        ('noise = "12 mV"', 'noise = "13 mV"', "what it says of a.csv"),
        ('skip = "2 ms"', "holdout = true", "what it says of b.csv"),
        ('input = "V"', 'input = "V", max_voltage = "5 V"', "its device"),
        ("effects = []", 'linear = "oscillator"', "linear part"),
        ("[effect.cubic-stiffness]\nk3 = 2.0", "[effect.oscillator]\nquality = 20.0", "[effect.oscillator]"),
    ],
)
def test_what_the_run_depends_on_may_not(lab, part, instead, says):
    with pytest.raises(UserError, match=re.escape(says)) as caught:
        loads(lab, CAMPAIGN.replace(part, instead))
    assert caught.value.where == "campaign.toml" and "fit the campaign again" in caught.value.do


def test_a_record_more_or_less_is_told(lab):
    with pytest.raises(UserError, match=r"b\.csv: is no longer part"):
        loads(lab, HEAD + "[[record]]\n" + RECORDS[0])


def test_settings_of_other_effects_wait_as_they_are_today(lab):
    text = CAMPAIGN.replace("k3 = 2.0", "k3 = 3.0").replace('fixed = ["velocity"]', 'fixed = ["friction"]')
    (lab / "campaign.toml").write_text(text, encoding="utf-8")
    model = load_run(lab / "run").model
    (lab / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    assert dict(model.start)["cubic-stiffness.k3"] == 3.0 and "coulomb-friction.friction" in model.held


def test_an_effect_file_counts_if_the_run_has_its_effect(lab):
    own = (lab / "own.toml").read_text(encoding="utf-8")
    bare = own.replace('["my-spring"]', "[]").replace('effect_files = ["my_effect.py"]\n', "")
    assert loads(lab, bare, "own", "own.toml").effect_files == ((lab / "my_effect.py").resolve(),)
    other = OWN.replace("state.z**3", "state.z**3 * 2")
    loads(lab, other, "run", "my_effect.py")
    with pytest.raises(UserError, match=r"my_effect\.py: has changed since this run, so it is not run"):
        loads(lab, other, "own", "my_effect.py")


def test_a_run_of_an_earlier_version_still_loads(lab):
    document = read_run(lab / "own")
    for key in ("said", "effects_from"):
        del document["campaign"][key]
    for floor in document["state"]["noise"]:  # whose lines its words told
        del floor["lines"]
        floor["method"] += "; mains hum, 50% of its power, is part of it"
    old = lab / "old"
    old.mkdir()
    (old / "run.json").write_text(json.dumps(document), encoding="utf-8")
    assert load_run(old).model.names == ("my-spring",)
    assert all(record.noise.lines == (HUMS,) for record in load_run(old).campaign.records)
    with pytest.raises(UserError, match=r"own\.toml: has changed since this run"):
        loads(lab, "# a comment\n" + (lab / "own.toml").read_text(encoding="utf-8"), "old", "own.toml")
