"""What was written from a misfit stands in the place of named effects only if it is better than they are."""

from __future__ import annotations

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.diagnosis.diagnose import _says_more
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model


def test_more_numbers_that_tell_no_more_replace_no_name() -> None:
    """A loudspeaker's stiffening suspension and losses had left 5.79 noise floors, and a formula of thirteen numbers
    that left 5.77 took their place: "no effect of the library helps"."""
    case = draw(41, ("cubic-stiffness",), size=0.05, noise=0.004, records=4, length=700)
    campaign, library = campaign_of(case), built_in()
    start = Model(campaign.device)
    named = fit(start + library["cubic-stiffness"](), campaign)
    bent = fit(start + library["cubic-stiffness"]() + library["residual-stress"](), campaign)
    assert bent.fitted.chi2 <= named.fitted.chi2 * 1.001
    assert not _says_more(named, bent)
    assert not _says_more(named, fit(start, campaign))
    assert _says_more(fit(start, campaign), named)
