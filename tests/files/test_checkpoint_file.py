"""Run files: back again bit for bit, and refused with a reason when they are damaged or something else."""

from __future__ import annotations

import dataclasses
import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota.errors import CheckpointError
from rota.files.checkpoint_file import read_checkpoint, write_checkpoint
from rota.model.mission import DiscSensor, Fleet, Mission
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planning.checkpoint import Checkpoint

SEED = 2**70


@pytest.fixture
def run() -> Checkpoint:
    fleet = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=25))
    fleet = dataclasses.replace(fleet, robots=tuple(fleet.equal_robot(name) for name in "abc"))
    area = MultiPolygon([box(0, 0, 100, 100)])
    rng = np.random.default_rng(0)
    return Checkpoint(
        mission=Mission(name="three", area=area, fleet=fleet, planning=SwarmSettings()),
        seed=SEED,
        steps=9,
        steps_at_rest=1,
        thinned_m=0.05,
        names=np.array([2, 0, 1]),
        places_m=rng.uniform(0, 100, (3, 2)),
        velocities_m_s=rng.normal(size=(3, 2)),
        kept_steps=np.array([0, 0, 0, 4]),
        kept_robots=np.array([0, 1, 2, 1]),
        kept_places_m=rng.uniform(0, 100, (4, 2)),
        recent_m=rng.uniform(0, 100, (4, 3, 2)),
        past=rng.uniform(0, 100, (9, 4, 3)),
        news_m=rng.uniform(0, 100, 5),
    )


def test_a_run_comes_back_bit_for_bit(run: Checkpoint, tmp_path: Path) -> None:
    path = tmp_path / "a.rota-run"
    write_checkpoint(run, path)
    assert [file.name for file in tmp_path.iterdir()] == ["a.rota-run"]
    back = read_checkpoint(path)
    for field in dataclasses.fields(run):
        mine, theirs = getattr(run, field.name), getattr(back, field.name)
        assert np.array_equal(mine, theirs) if isinstance(mine, np.ndarray) else mine == theirs, field.name
    write_checkpoint(back, tmp_path / "b.rota-run")
    assert (tmp_path / "b.rota-run").read_bytes() == path.read_bytes()


def test_what_is_cut_off_or_flipped_is_refused_at_every_place(run: Checkpoint, tmp_path: Path) -> None:
    path, data = tmp_path / "a.rota-run", b""
    write_checkpoint(run, path)
    data = path.read_bytes()
    for length in range(0, len(data) - 1, 97):
        path.write_bytes(data[:length])
        with pytest.raises(CheckpointError, match="not a whole one"):
            read_checkpoint(path)
    middle = data.index(run.places_m.tobytes())
    path.write_bytes(data[:middle] + bytes([data[middle] ^ 1]) + data[middle + 1 :])
    with pytest.raises(CheckpointError, match="not a whole one"):
        read_checkpoint(path)


def test_bytes_that_are_changed_anywhere_are_refused_or_do_no_harm(run: Checkpoint, tmp_path: Path) -> None:
    path = tmp_path / "a.rota-run"
    write_checkpoint(run, path)
    data, rng = path.read_bytes(), np.random.default_rng(1)
    # methods of compression, the flag of an encrypted entry, and unclosed brackets in numpy's headers among them
    places = [*range(60), *range(len(data) - 100, len(data)), *rng.integers(0, len(data), 60)]
    refused = []
    for place, value in itertools.product(places, (1, 14, ord("("))):
        path.write_bytes(data[:place] + bytes([value]) + data[place + 1 :])
        try:
            read_checkpoint(path)
        except CheckpointError as error:
            refused.append(str(error))
    assert len(refused) > 100
    assert all(reason.startswith(str(path)) for reason in refused)


def test_other_files_are_refused(tmp_path: Path) -> None:
    np.save(tmp_path / "array.npy", np.zeros(3))
    np.savez(tmp_path / "other.npz", values=np.zeros(3))
    np.savez(tmp_path / "objects.npz", head=np.array([{}], object))
    (tmp_path / "plan.json").write_text('{"rota_plan": 1}')
    needed = r"a run file \('rota plan' writes one when a swarm is stopped\) is needed|a run file is needed"
    for name in ("array.npy", "other.npz", "objects.npz", "plan.json", "nothing", "."):
        with pytest.raises(CheckpointError, match=needed):
            read_checkpoint(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("places_m", np.full((3, 2), np.nan), "places_m: holds a value that is not finite"),
        ("velocities_m_s", np.zeros((2, 2)), r"velocities_m_s: has the shape \(2, 2\); \(3, 2\) is needed"),
        ("names", np.array([0, 0, 1]), "names: every number from 0 to 2 is needed once"),
        ("names", np.array([0.0, 2, 1]), "names: holds float64; int64 is needed"),
        ("kept_robots", np.array([0, 1, 2, 3]), "kept places: numbers from 0 to 2"),
        ("kept_steps", np.array([0, 0, 0, 7]), "kept places: numbers from 0 to 6"),
        ("steps", 2, "steps: 2 with 4 recent places"),
        ("steps", "nine", "steps: 'nine' is not allowed"),
        ("thinned_m", -1.0, "thinned_m: -1.0 is not allowed"),
        ("rota_run", 2, "rota_run: version 2 is not known; this Rota reads version 1"),
        ("recent_m", None, "recent_m: is missing"),
        ("plan", {}, "not a plan file"),
    ],
)
def test_values_that_cannot_be_are_refused(run: Checkpoint, tmp_path: Path, name: str, value: Any, words: str) -> None:
    path = tmp_path / "a.rota-run"
    write_checkpoint(run, path)
    with np.load(path) as file:
        parts = dict(file)
    if name in parts:
        parts[name] = value
    else:
        head = json.loads(parts["head"].tobytes())
        assert name in head
        parts["head"] = np.frombuffer(json.dumps(head | {name: value}).encode(), np.uint8)
    with path.open("wb") as out:
        np.savez(out, **{key: part for key, part in parts.items() if part is not None})
    with pytest.raises(CheckpointError, match=words) as refused:
        read_checkpoint(path)
    assert str(refused.value).startswith(str(path))
