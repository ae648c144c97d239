"""What `ident discover` and `ident diagnose` share: the diagnosis of a fit, told and kept."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .fit import command_line
from .limit import Limit, OutOfTime
from .output import progress, say, say_fit, say_folder, say_json, say_sheet

if TYPE_CHECKING:
    from ..diagnosis.answer import Diagnosis
    from ..diagnosis.search.steps import Walked
    from ..fit import Fit


def walk(walked: Walked, folder: Path, *, force: bool, as_json: bool, limit: Limit) -> None:
    """Run the loop from a fit or from where it was stopped, write the last model as a run, and tell the story.

    The folder is written after every step, so that a walk that is stopped leaves what it found.
    """
    from ..diagnosis.diagnose import diagnose
    from ..diagnosis.document import diagnosis_dict, lineage_of
    from ..report.diagnosis_view import advice, sections
    from ..report.parts import parts_dict
    from ..report.run_folder import write_run

    kept = _Kept(folder, force)
    try:
        kept.keep(walked)
        with limit.running():
            found = diagnose(walked, None, progress, _free_file(folder), True, kept.within(limit))
    except OutOfTime:
        kept.tell("the time is over", as_json)
        return
    except KeyboardInterrupt:
        kept.tell("stopped", as_json)
        raise
    force = True  # what is there is this walk's own
    lineage = lineage_of(found.discovery.start, found.discovery.steps)
    document = diagnosis_dict(found) | {"advice": advice(found)}
    documents = {"diagnosis.json": document, "parts.json": parts_dict({"diagnosis": sections(found)})}
    write_run(
        found.discovery.final, folder, force=force, command=command_line(), lineage=lineage, documents=documents,
        report=progress,
    )  # fmt: skip
    if as_json:
        say_json(document)
        return
    say_fit(found.discovery.final)
    tell(found)
    say_folder(folder)


class _Kept:
    """The run folder of a walk that goes on."""

    def __init__(self, folder: Path, force: bool):
        self.folder, self._force = folder, force
        self._document: dict[str, Any] = {}
        self._fit: Fit | None = None

    def keep(self, walked: Walked) -> None:
        """Write the last fit and the steps so far."""
        from ..diagnosis.document import lineage_of, unfinished_dict
        from ..report.run_folder import write_run
        from ..report.walk_json import FILE, walk_dict

        self._fit = walked.final
        self._document = unfinished_dict(walked)
        write_run(
            self._fit, self.folder, force=self._force, command=command_line(),
            lineage=lineage_of(walked.start, walked.steps),
            documents={"diagnosis.json": self._document, FILE: walk_dict(walked)}, page=False,
        )  # fmt: skip
        self._force = True

    def within(self, limit: Limit) -> Callable[[Walked], None]:
        """`keep`, which the clock does not interrupt."""

        def kept(walked: Walked) -> None:
            with limit.waiting():
                self.keep(walked)
            limit.ask()

        return kept

    def tell(self, why: str, as_json: bool) -> None:
        """What a walk that was stopped has left."""
        if as_json:
            say_json(self._document)
            return
        if self._fit is not None:
            say_fit(self._fit)
            names = ", ".join(step["added"] for step in self._document["steps"]) or "nothing yet"
            say(f"{why}: added so far: {names}. None of it was questioned, and more may be missing.")
            say(f"run folder: {self.folder} (`ident report {self.folder}` draws its page; --resume goes on)")


def _free_file(folder: Path) -> Path:
    """Where an effect file may be written beside a run folder; nothing of the user's is overwritten."""
    names = (folder.with_name(f"{folder.name}_effect{'' if i == 1 else i}.py") for i in range(1, 1000))
    return next(path for path in names if not path.exists())


def tell(found: Diagnosis) -> None:
    """The diagnosis on the terminal."""
    from ..diagnosis.document import lineage_of
    from ..report.candidates_view import later_sheet, ranking_sheet
    from ..report.diagnosis_view import advice, verdict_words
    from ..report.story import change_sheet

    say(f"Where the first model fails: {found.summary}")
    say()
    if found.discovery.ranking:
        say_sheet(ranking_sheet(found))
    if (later := later_sheet(found)) is not None:
        say_sheet(later)
    lineage = lineage_of(found.discovery.start, found.discovery.steps)
    if lineage:
        say_sheet(change_sheet(lineage))
    for sentence in advice(found):
        say(sentence)
    say(verdict_words(found))
