"""Which changes of the sources let a kernel be compiled anew."""

from __future__ import annotations

import os
import shutil
import time
from pathlib import Path

import pytest

from rota.compiled import source_stamp as stamps
from rota.compiled.source_stamp import SOURCE, changed_since, imports_of, meanings_of, source_stamp

TEXTS = {
    "a_kernels": "from rota.b_kernels import (\n    b,\n)\n",
    "b_kernels": "from rota import c_kernels, other\n",
    "c_kernels": "C = 1\n",
    "unrelated_kernels": "",
}


def written(folder: Path) -> dict[str, Path]:
    """A small package by the name of rota."""
    files = {name: folder / "rota" / f"{name}.py" for name in TEXTS}
    (folder / "rota").mkdir(parents=True)
    for name, text in TEXTS.items():
        files[name].write_text(text)
    return files


def stamp(file: Path, folder: Path) -> str:
    source_stamp.cache_clear()
    imports_of.cache_clear()
    return source_stamp(file, folder)


def test_a_change_far_down_counts_and_one_elsewhere_does_not(tmp_path: Path) -> None:
    files = written(tmp_path)
    before = stamp(files["a_kernels"], tmp_path)
    files["unrelated_kernels"].write_text("D = 1\n")
    assert stamp(files["a_kernels"], tmp_path) == before
    files["c_kernels"].write_text("C = 2\n")
    assert stamp(files["a_kernels"], tmp_path) != before


def test_what_a_file_of_another_distribution_imports_of_its_own_counts_as_well(tmp_path: Path) -> None:
    files = written(tmp_path / "src")
    package = tmp_path / "studies" / "rota_studies" / "method"
    package.mkdir(parents=True)
    for folder in (package, package.parent):
        (folder / "__init__.py").touch()
    kernels, beside = package / "d_kernels.py", package / "e_kernels.py"
    kernels.write_text("from rota.a_kernels import a\nfrom rota_studies.method.e_kernels import e\n")
    beside.write_text("E = 1\n")
    before = stamp(kernels, tmp_path / "src")
    beside.write_text("E = 2\n")
    changed = stamp(kernels, tmp_path / "src")
    assert changed != before
    files["c_kernels"].write_text("C = 2\n")
    assert stamp(kernels, tmp_path / "src") != changed


def test_what_is_imported_for_types_alone_does_not_count(tmp_path: Path) -> None:
    files = written(tmp_path)
    shown = (
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:  # why\n    from rota.c_kernels import C\n\n    D = 1\n"
    )
    files["unrelated_kernels"].write_text(f"{shown}\nfrom rota.b_kernels import b\n")
    imports_of.cache_clear()
    assert imports_of(files["unrelated_kernels"], tmp_path) == {files["b_kernels"]}


def test_no_kernel_is_compiled_anew_when_missions_or_plans_get_a_field() -> None:
    """What kernels import, at whatever distance, is of kernels, constants and kinds of arrays."""
    imports_of.cache_clear()
    for file in SOURCE.rglob("*kernels.py"):
        found, new = set[Path](), {file}
        while new:
            found |= new
            new = {other for one in new for other in imports_of(one)} - found
        models = {other.name for other in found if other.parent.name == "model"}
        assert models <= {"arrays.py", "limits.py"}, file


def test_comments_docstrings_and_layout_do_not_count(tmp_path: Path) -> None:
    files = written(tmp_path)
    before = stamp(files["a_kernels"], tmp_path)
    files["c_kernels"].write_text('"""What c is."""\n\nC = (  # one\n    1\n)\n')
    assert stamp(files["a_kernels"], tmp_path) == before
    first, second = "def f(x):\n  return x\n", 'def f(x):\n  """The same."""\n\n  return x  # x\n'
    one, same, other, broken = meanings_of([first.encode(), second.encode(), first.replace("x", "y").encode(), b"def"])
    assert one == same
    assert len({one, other, broken}) == 3


def test_meanings_are_kept_for_other_processes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    stamps._kept_meanings.cache_clear()
    first = meanings_of([b"C = 1\n"])
    stamps._kept_meanings.cache_clear()
    monkeypatch.setattr(stamps.ast, "parse", None)
    assert meanings_of([b"C = 1\n"]) == first
    stamps._kept_meanings.cache_clear()


def test_a_copy_elsewhere_has_the_same_stamp(tmp_path: Path) -> None:
    files = written(tmp_path / "one")
    shutil.copytree(tmp_path / "one", tmp_path / "two", copy_function=shutil.copyfile)
    other = tmp_path / "two" / "rota" / "a_kernels.py"
    assert stamp(files["a_kernels"], tmp_path / "one") == stamp(other, tmp_path / "two")


def test_what_is_written_while_a_process_runs_is_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever imported a file before it was changed must neither keep code for the new contents nor load it."""
    files = written(tmp_path)
    seen = set()
    for started_s in (0.0, time.time() + 60):  # before the files were written, and after
        for process in ("one", "other"):
            monkeypatch.setattr(stamps, "STARTED_S", started_s)
            monkeypatch.setattr(stamps, "THIS_PROCESS", process)
            seen.add((started_s == 0, stamp(files["a_kernels"], tmp_path)))
    assert sorted(changed for changed, _ in seen) == [False, True, True]


def test_a_file_put_in_place_later_is_new_whatever_its_date(tmp_path: Path) -> None:
    file = tmp_path / "a.py"
    file.write_text("")
    os.utime(file, (0, 0))
    assert changed_since([file], time.time() - 60)
    assert not changed_since([file], time.time() + 60)


def test_a_date_to_come_tells_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a machine whose clock is behind that of another, which wrote the files."""
    file = tmp_path / "a.py"
    file.write_text("")
    monkeypatch.setattr(stamps.time, "time", lambda: file.stat().st_ctime - 3600)
    assert not changed_since([file], file.stat().st_ctime - 7200)
