"""Sweep files: what they stand for, and their faults, all at once and each at its place."""

from __future__ import annotations

from pathlib import Path

import jsonschema
import pytest
from ruamel.yaml import YAML

from rota.errors import MissionError
from rota.files.sweep_file import read_sweep, sweep_schema

EXAMPLE = Path(__file__).parents[2] / "examples" / "sweep.yaml"


def faults_of(folder: Path, text: str) -> list[str]:
    (folder / "yard.yaml").touch()
    path = folder / "sweep.yaml"
    path.write_text(text)
    with pytest.raises(MissionError) as caught:
        read_sweep(path)
    return [fault.removeprefix(f"{path}:") for fault in caught.value.faults]


def test_patterns_and_seeds_are_written_out(tmp_path: Path) -> None:
    (tmp_path / "more").mkdir()
    for name in ("b.yaml", "a.yaml", "more/c.yaml"):
        (tmp_path / name).touch()
    sweep = tmp_path / "sweep.txt"
    sweep.write_text("rota_sweep: 1\nname: s\nmissions: [more/c.yaml, '*.yaml']\nseeds: {first: 3, count: 2}\n")
    read = read_sweep(sweep)
    assert list(read.missions) == ["more/c.yaml", "a.yaml", "b.yaml"]
    assert read.missions["a.yaml"] == tmp_path / "a.yaml"
    assert read.file.all_seeds == [3, 4]
    assert (read.file.planners, read.file.efforts, read.file.time_limit_s) == (None, None, None)


def test_every_fault_is_told_at_its_place(tmp_path: Path) -> None:
    text = """\
rota_sweep: 1
name: s
missions: [yard.yaml, none.yaml, 'no*.yaml']
planers: [patrol]
planners: [patrl, swarm, swarm]
efforts: [slow]
settings:
  fleet.speed_m_s: []
  patrol.effort: [quick]
  fleet..speed: [1]
  period_s: [1, 1]
seeds: [0, -1]
time_limit_s: 0
"""
    folder = tmp_path.absolute()
    assert faults_of(tmp_path, text) == [
        f"3:23: missions[1]: there is no such file in {folder}",
        f"3:34: missions[2]: there is no such file in {folder}",
        "4:1: planers: unknown key; did you mean 'planners'?",
        "5:12: planners[0]: \"patrl\" is not known; did you mean 'patrol'?",
        '5:26: planners[2]: "swarm" is given twice; each once is needed',
        '6:11: efforts[0]: "slow" is not allowed; quick, normal or high is needed',
        "8:20: settings.fleet.speed_m_s: [] is not allowed; it must not be empty",
        "9:18: settings.patrol.effort: is not allowed here; use efforts",
        "10:17: settings.fleet..speed: is no path of a field; names with dots between them are needed",
        "11:17: settings.period_s[1]: 1 is given twice; each once is needed",
        "12:12: seeds[1]: -1 is not allowed; it must be at least 0",
        "13:15: time_limit_s: 0 is not allowed; it must be at least 0.001",
    ]


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("name: s\nmissions: [yard.yaml]\n", "1:1: rota_sweep: is missing; it is required"),
        ("rota_sweep: 1\nname: s\nmissions: []\n", "3:11: missions: [] is not allowed; it must not be empty"),
        ("rota_sweep: 1\nname: s\nmissions: [yard.yaml]\nseeds: many\n", "4:8: seeds: "),
    ],
)
def test_single_faults(tmp_path: Path, text: str, fault: str) -> None:
    assert faults_of(tmp_path, text)[0].startswith(fault)


def test_the_example_follows_the_schema() -> None:
    schema = sweep_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(YAML(typ="safe", pure=True).load(EXAMPLE.read_text()), schema)
    assert len(read_sweep(EXAMPLE).file.all_seeds) == 3
