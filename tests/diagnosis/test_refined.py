"""What refines a law is held at its usual value, and free where it is scored with it."""

from ident.diagnosis.ranking.starts import all_free
from ident.effects.registry import built_in


def test_an_effect_is_scored_with_what_refines_it():
    effect = built_in()["viscoelastic-support"]
    free = {p.name: p.fitted for p in all_free(effect)().declared()}
    assert all(free.values()) and free.keys() == {p.name for p in effect().declared()}
    assert [p.name for p in effect().declared() if not p.fitted] == ["share"]
