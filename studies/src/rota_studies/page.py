"""What the pages of all studies have in common: the claims at the top, lists, and where their numbers come from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from rota_studies.section import Section
from rota_studies.tables import NOTHING, Table
from rota_studies.verdict import RULE, Verdict


def claims(sections: Sequence[Section], standing: Sequence[Verdict] = ()) -> list[str]:
    """The rule, and a row for each claim: those of the sections, then those that no figure is evidence for."""
    judged = [(one, _where(section)) for section in sections for one in section.verdicts]
    judged += [(one, NOTHING) for one in standing]
    if not judged:
        return []
    counts = Counter(one.outcome for one, _ in judged)
    told = ", ".join(f"{outcome}: {count}" for outcome, count in counts.items())
    table = Table(
        title=f"{len(judged)} claims ({told})",
        head=("the paper's claim", "section", "verdict", "why", "figure"),
        rows=tuple((one.claim, one.place, f"**{one.outcome}**", one.why, figure) for one, figure in judged),
        words=(0, 1, 2, 3, 4),
    )
    return ["## The paper's claims", RULE, table.markdown]


def _where(section: Section) -> str:
    return f"{'extra ' if section.extra else ''}{section.figure}"


def listed(lines: Sequence[str]) -> str:
    """Lines as a Markdown list."""
    return "\n".join(f"- {line}" for line in lines)


def made_from(study: str) -> str:
    """Where the numbers of a page come from, and how it is made again."""
    return (
        f"Every number under **Here** and in columns of ours, every verdict and every picture is made from the stored "
        f"runs in [{study}.json]({study}.json), one line each: what was run, with which seed, and what came out. "
        f"`rota study {study} --from {study}.json -o FOLDER` makes this page from them again, byte for byte and "
        f"without planning; `rota study {study} -o FOLDER` runs all anew. The paper's numbers are as printed."
    )
