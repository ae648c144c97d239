"""What was written from a misfit stands in the place of named effects only if it is better than they are."""

from __future__ import annotations

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.search.steps import Discovery, Step
from ident.diagnosis.search.written import _by_itself, _says_more
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model


def test_more_numbers_that_tell_no_more_replace_no_name() -> None:
    """A loudspeaker's stiffening suspension and losses had left 5.79 noise floors, and a formula of thirteen numbers
    that left 5.77 took their place: "no effect of the library helps"."""
    case = draw(41, ("cubic-stiffness",), size=0.05, noise=0.004, records=4, length=700, detail="plain")
    campaign, library = campaign_of(case), built_in()
    start = Model(campaign.device)
    named = fit(start + library["cubic-stiffness"](), campaign)
    bent = fit(start + library["cubic-stiffness"]() + library["residual-stress"](), campaign)
    assert bent.fitted.chi2 <= named.fitted.chi2 * 1.001
    assert not _says_more(named, bent)
    assert not _says_more(named, fit(start, campaign))
    assert _says_more(fit(start, campaign), named)


def test_what_was_written_stands_alone_where_the_names_before_it_do_no_more() -> None:
    """|z| of a beam with a crack had two names before it, of which nothing remained beside it."""
    case = draw(42, ("cubic-stiffness",), size=0.05, noise=0.004, records=4, length=700)
    campaign, library = campaign_of(case), built_in()
    start = fit(Model(campaign.device), campaign)
    first = prepare(start)
    for hidden, superfluous in (("quadratic-stiffness", True), ("cubic-stiffness", False)):
        last = ({"quadratic-stiffness", "cubic-stiffness"} - {hidden}).pop()
        one = fit(start.model + library[hidden](), campaign)
        both = fit(one.model + library[last](), campaign)
        steps = tuple(Step(n, 1.0, 1.0, (n,), "effect", f) for n, f in ((hidden, one), (last, both)))
        alone = _by_itself(Discovery("not-in-library", start, steps, (), {}, (), first), first, lambda _: None)
        assert (alone is not None) is superfluous
        if alone is not None:
            assert alone.model.names == (last,)
