"""Parts of the report that commands after the fit have left in a run folder."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ident.fit import Fit
    from ident.report.html import Section


def drawn_sections(folder: Path, fit: Fit) -> list[Section]:
    """The posterior and the attribution, where they were drawn."""
    from ident.report.attribution_view import attribution_section
    from ident.report.posterior_view import posterior_section

    found = [posterior_section(folder, fit.model.device), attribution_section(folder)]
    return [section for section in found if section is not None]
