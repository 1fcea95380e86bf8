"""`rota rehearse` from the shell: what it prints, draws and refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from PIL import Image
from tests.rehearsal.rehearsed_plans import round_a_block

from rota import write_plan
from rota.command.cli import run


@pytest.fixture
def plan(tmp_path: Path) -> str:
    path = tmp_path / "plan.rota.json"
    write_plan(round_a_block(), path)
    return str(path)


def test_a_rehearsal_is_told_drawn_and_given_as_json(
    plan: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = tmp_path / "rehearsed.png"
    asked = [plan, "--hours", "1", "--runs", "4", "--failures-per-hour", "0.5", "--speed-noise", "5%", "--wind", "0.1"]
    assert run(["rehearse", *asked, "-o", str(picture)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == (
        "4 runs of 1 h, 2 robots, seed 0: each robot fails 0.5 times an hour, speeds vary by 5 %,"
        " wind of 0.1 m/s from anywhere, all wait for who is late"
    )
    assert Image.open(picture).width > 1000
    assert run(["rehearse", *asked, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["rota_rehearsal"], told["runs"], told["conditions"]["speed_noise"]) == (1, 4, 0.05)
    assert [each["name"] for each in told["demands"]] == ["door", "corner", "area"]
    assert f"{100 * told['available']['mean']:.1f}" in lines[1]


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (["--failures-per-hour", "nan"], "--failures-per-hour: nan is not allowed; must be at least 0 and at most"),
        (["--failures-per-hour", "-1"], "--failures-per-hour: -1 is not allowed"),
        (["--wind", "1,1e300"], "--wind: '1,1e300' is not allowed"),
        (["--runs", "1e3"], '--runs: "1e3" is not allowed; a whole number is needed'),
        (["-o", ""], "an empty path: has no suffix, which tells the format of a picture"),
        (["--hours", "0"], "--hours: 0 is not allowed; must be a finite number greater than 0"),
        (["--runs", "0"], "--runs: 0 is not allowed; must be 1 to 100000"),
        (["--speed-noise", "much"], "--speed-noise: 'much' is not allowed; a share is needed, such as 5% or 0.05"),
        (["--speed-noise", "50%"], "--speed-noise: 0.5 is not allowed; must be at least 0 and at most 0.3"),
        (["--wind", "-1"], "--wind: '-1' is not allowed; M_S,FROM_DEG is needed"),
        (["--wind", "1,2,3"], "--wind: '1,2,3' is not allowed"),
        (["--wind", "nan"], "--wind: 'nan' is not allowed"),
        (["--wind", "5"], "--wind: 5 is not allowed; r0 makes 1 m/s through the air"),
        (["--late-relief", "-1"], "--late-relief: -1 is not allowed; must be at least 0 and at most 100000"),
        (["--late-relief", "5"], "--late-relief: 5 is not allowed; nobody charges in this plan"),
        (["--seed", "-3"], "--seed: -3 is not allowed; must be a whole number of at least 0"),
        (["-o", "picture.txt"], "picture.txt: '.txt' is no format for a picture"),
    ],
)
def test_bad_input_is_refused_by_its_option(
    given: list[str], told: str, plan: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["rehearse", plan, *given]) == 2
    assert capsys.readouterr().err.startswith(f"rota: error: {told}")


def test_an_unknown_file_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["rehearse", str(tmp_path / "none.json")]) == 2
    assert "no such file; a plan file ('rota plan' writes one) is needed" in capsys.readouterr().err
