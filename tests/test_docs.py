"""The effect files that the documents show are loaded and held to their own rules."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from ident.diagnosis.evidence.equivalences import equivalence, mistaken
from ident.effects import Drive, State
from ident.effects.likeness import SAME_LOSS
from ident.effects.registry import built_in, registry

ROOT = Path(__file__).parent.parent
DRIVE = Drive(V=2.0, rate=300.0, omega=2000.0, gain=1e-4)


def _fences(document: str, language: str) -> list[str]:
    text = (ROOT / document).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize(("number", "name"), [(0, "gas-drag"), (1, "slow-support")])
def test_the_effects_of_the_guide_load_and_vanish_at_zero(tmp_path, number, name):
    file = tmp_path / "my_effect.py"
    file.write_text(_fences("docs/add-an-effect.md", "python")[number], encoding="utf-8")
    effect_class = registry([file])[name]
    amplitudes = [p.name for p in effect_class.parameters if p.kind == "amplitude"]
    state = State(z=1e-5, v=0.02, hidden=tuple(4e-6 for _ in effect_class().state0()))

    off = effect_class(**dict.fromkeys(amplitudes, 0.0))
    on = effect_class(**dict.fromkeys(amplitudes, 1.0))

    assert float(off.force(state, DRIVE, 0.0)) == 0.0
    assert float(on.force(state, DRIVE, 0.0)) < 0.0
    assert len(on.rate(state, DRIVE, 0.0)) == len(on.state0()) == len(effect_class.hidden_units)


def test_the_effect_of_the_guide_passes_for_the_library_effects_that_it_is_alike(tmp_path):
    file = tmp_path / "my_effect.py"
    file.write_text(_fences("docs/add-an-effect.md", "python")[0], encoding="utf-8")
    known = registry([file])
    assert equivalence(known["gas-drag"], known["coulomb-friction"]) == SAME_LOSS
    assert equivalence(known["gas-drag"], known["cubic-stiffness"]) is None
    assert "gas-drag" in mistaken(known["quadratic-damping"], known)


def test_the_effect_of_the_contributing_page_is_the_one_of_the_library():
    library = "ident.effects.library"
    shown: dict = {"__name__": f"{library}.shown", "__package__": library}
    exec(_fences("CONTRIBUTING.md", "python")[0], shown)
    state = State(z=3e-6, v=0.0)
    expected = built_in()["cubic-stiffness"](k3=7e9).force(state, DRIVE, 0.0)
    assert shown["CubicStiffness"](k3=7e9).force(state, DRIVE, 0.0) == expected != 0.0


def test_the_campaign_of_the_guide_is_valid_toml():
    campaign = tomllib.loads(_fences("docs/campaign.md", "toml")[0])
    assert [record["kind"] for record in campaign["record"]] == ["trace", "sweep"]
