"""Commands of other distributions: found by their entry point, and told where they are missing or broken."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.test_other_planners import install

from rota.command import registry
from rota.command.cli import run

BELLS = """
import typer

app = typer.Typer(help="Ring bells.")


@app.command("ring")
def ring(times: int = 1) -> None:
    typer.echo("ding " * times)


@app.command("oil")
def oil() -> None:
    raise SystemExit(3)
"""


@pytest.fixture
def bells(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    (tmp_path / "bells.py").write_text(BELLS)
    install(tmp_path, "bells", "bells = bells:app\nbroken = nowhere:app\nplan = bells:app\n", group="rota.commands")
    monkeypatch.syspath_prepend(str(tmp_path))
    registry.offered_commands.cache_clear()
    yield
    registry.offered_commands.cache_clear()


@pytest.mark.usefixtures("bells")
def test_a_command_of_another_distribution_is_listed_and_runs(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--help"]) == 0
    listed = [line.strip() for line in capsys.readouterr().out.splitlines()]
    assert any(line.split() == ["bells", "Ring", "bells."] for line in listed)
    assert sum(line.startswith("plan ") for line in listed) == 1
    assert run(["bells", "ring", "--times", "2"]) == 0
    assert capsys.readouterr().out == "ding ding \n"
    assert run(["bells", "oil"]) == 3
    assert run(["plan", "missing.yaml"]) == 2  # Rota's own
    assert "missing.yaml" in capsys.readouterr().err


@pytest.mark.usefixtures("bells")
def test_a_command_that_cannot_be_loaded_tells_why(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["broken", "--loudly"]) == 2
    assert "broken: cannot be loaded from nowhere:app: No module named 'nowhere'" in capsys.readouterr().err


def test_where_studies_are_missing_the_command_tells_how_to_get_them(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(registry, "offered_commands", dict)
    for asked in (["study"], ["study", "sun2019", "-o", "out"]):
        assert run(asked) == 2
        told = capsys.readouterr()
        assert told.out == ""
        assert told.err == (
            "rota: error: study: not installed; it is the distribution rota-studies, which `pip install ./studies`"
            " installs in a checkout of Rota\n"
        )
    assert run(["--help"]) == 0
    assert "..." not in capsys.readouterr().out.replace("ARGS]...", "")
