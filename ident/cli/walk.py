"""What `ident discover` and `ident diagnose` share: the diagnosis of a fit, told and kept."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from .fit import command_line
from .output import progress, say, say_fit, say_json, say_sheet

if TYPE_CHECKING:
    from ident.diagnosis.diagnose import Diagnosis
    from ident.fit import Fit


def walk(start: Fit, folder: Path, *, force: bool, as_json: bool) -> None:
    """Run the loop from a fit, write the last model as a run, and tell the story."""
    from ident.diagnosis.document import diagnosis_dict, lineage_of
    from ident.report.diagnosis_view import advice, sections
    from ident.report.run_folder import write_run

    found = examine(start, _free_file(folder), keeps_walk=True)
    lineage = lineage_of(found.discovery, "the first fit")
    document = diagnosis_dict(found) | {"advice": advice(found)}
    write_run(
        found.discovery.final, folder, force=force, command=command_line(), lineage=lineage,
        documents={"diagnosis.json": document}, extra={"sections": sections(found, lineage)}, report=progress,
    )  # fmt: skip
    if as_json:
        say_json(document)
        return
    say_fit(found.discovery.final)
    tell(found)
    say(f"run folder: {folder}")
    say(f"report:     {folder / 'report.html'}")


def _free_file(folder: Path) -> Path:
    """Where an effect file may be written beside a run folder; nothing of the user's is overwritten."""
    names = (folder.with_name(f"{folder.name}_effect{'' if i == 1 else i}.py") for i in range(1, 1000))
    return next(path for path in names if not path.exists())


def examine(start: Fit, effect_file: Path | None = None, *, keeps_walk: bool = False) -> Diagnosis:
    """The diagnosis of a fit with all effects that its campaign knows; other arguments as in `diagnose`."""
    from ident.diagnosis.diagnose import diagnose
    from ident.effects.registry import registry

    return diagnose(start, registry(start.campaign.effect_files), progress, effect_file, keeps_walk)


def tell(found: Diagnosis) -> None:
    """The diagnosis on the terminal."""
    from ident.diagnosis.document import lineage_of
    from ident.report.diagnosis_view import advice, ranking_sheet, verdict_words
    from ident.report.story import change_sheet

    say(f"Where the first model fails: {found.summary}")
    say()
    if found.discovery.ranking:
        say_sheet(ranking_sheet(found))
    lineage = lineage_of(found.discovery, "the first fit")
    if lineage:
        say_sheet(change_sheet(lineage))
    for sentence in advice(found):
        say(sentence)
    say(verdict_words(found))
