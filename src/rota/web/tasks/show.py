"""Plans checked, drawn and made ready to be played."""

from __future__ import annotations

import gzip
import tempfile
from pathlib import Path

from rota.errors import MissionError, PlanError
from rota.files.plan_file import plan_from_text
from rota.model.plan import Plan
from rota.web.refusal import Json, Refusal
from rota.web.store.plans import keep_plan, plan_text
from rota.web.tasks.context import Context
from rota.web.tasks.planning import new_plan


def kept_plan(context: Context, given: Json) -> Plan:
    """The plan that a message names."""
    return plan_from_text(plan_text(context.database, given["plan"]), "the plan")


def keep_uploaded_plan(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """Read, check and keep a plan file; the message names it."""
    from rota.check import check_plan

    try:
        plan = plan_from_text(body, given["name"])
    except PlanError as error:
        faults = [{"field": "", "path": [], "message": line} for line in str(error).splitlines()]
        raise Refusal(422, "this is no plan that can be used", faults) from None
    new = new_plan(plan, check_plan(plan), ())
    return {"plan": keep_plan(context.database, new, most=context.plans)}, b""


def require_change(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """Refuse a change that cannot be, such as the loss of all robots; the message says what was asked."""
    from rota.replanning.situation import Change, situation_after

    change = Change(at_s=given["at_s"], lost=tuple(given["lost"]), joined={}, late={})
    try:
        situation_after(kept_plan(context, given), change)
    except MissionError as error:
        raise Refusal(422, str(error)) from None
    return {}, b""


def playback(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """What players need of the plan, over about so many cells, packed by gzip."""
    from rota.check import check_plan
    from rota.playback.playback import playback_of

    plan = kept_plan(context, given)
    return {}, gzip.compress(playback_of(plan, check_plan(plan), given["cells"]), 5)


def page(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """The plan as one page that plays it without a network."""
    from rota.check import check_plan
    from rota.playback.page import page_text

    plan = kept_plan(context, given)
    return {}, page_text(plan, check_plan(plan)).encode()


def picture(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """The plan drawn, with the worst gap of every place, as PNG."""
    from rota.draw import draw_plan

    plan = kept_plan(context, given)
    with tempfile.TemporaryDirectory(prefix="rota-") as folder:
        path = Path(folder) / "plan.png"
        draw_plan(plan, path)
        return {}, path.read_bytes()
