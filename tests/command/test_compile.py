"""``rota compile``: what it compiled, where it is kept, and what it refuses."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rota.command.cli import run
from rota.compiled.code_cache import cache_folder, kept_names


def test_it_says_how_many_and_where_and_a_second_time_compiles_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compile", "bounce"]) == 0
    assert any(name.startswith("rota.planners.bounce.") for name in kept_names())
    capsys.readouterr()
    assert run(["compile", "bounce"]) == 0
    said = capsys.readouterr().err
    assert re.fullmatch(rf"rota: 0 functions compiled in \d+ s, kept in {re.escape(str(cache_folder()))}\n", said)


def test_unknown_planners_and_folders_that_cannot_be_written_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["compile", "bounces"]) == 2
    assert "'bounces' is not known; patrol, swarm, bounce" in capsys.readouterr().err
    (tmp_path / "rota").write_text("a file stands in the folder's place")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert run(["compile", "bounce"]) == 2
    assert f"{tmp_path / 'rota'} cannot be written; choose another folder by NUMBA_CACHE_DIR" in capsys.readouterr().err
