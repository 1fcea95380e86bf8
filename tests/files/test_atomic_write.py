"""Files appear whole or not at all."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from rota.errors import RotaError
from rota.files import atomic_write
from rota.files.atomic_write import require_writable, require_writable_folder, write_atomically


def test_a_new_file_gets_the_permissions_of_any_new_file(tmp_path: Path) -> None:
    write_atomically(tmp_path / "made", "ä\n")
    (tmp_path / "usual").write_text("x")
    assert (tmp_path / "made").read_bytes() == b"\xc3\xa4\n"
    assert (tmp_path / "made").stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_an_existing_file_keeps_its_permissions_and_a_link_its_target(tmp_path: Path) -> None:
    target, link = tmp_path / "target", tmp_path / "link"
    target.write_text("old")
    target.chmod(0o640)
    link.symlink_to(target)
    write_atomically(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert stat.S_IMODE(target.stat().st_mode) == 0o640


def test_a_failure_before_the_rename_leaves_the_old_file_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "plan"
    path.write_text("old")

    def full(_descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(atomic_write.os, "fsync", full)
    with pytest.raises(RotaError, match="plan: cannot be written: No space left on device"):
        write_atomically(path, "new")
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["plan"]


def test_a_kill_at_the_rename_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "plan"
    path.write_text("old")
    script = (
        "import os, signal\n"
        "from rota.files.atomic_write import write_atomically\n"
        "os.replace = lambda *_: os.kill(os.getpid(), signal.SIGKILL)\n"
        f"write_atomically({str(path)!r}, 'new' * 100000)\n"
    )
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == -9
    assert path.read_text() == "old"


def test_a_pipe_is_written_to_and_not_replaced(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read: list[str] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()))
    reader.start()
    write_atomically(pipe, "through")
    reader.join(timeout=10)
    assert read == ["through"]
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_places_that_cannot_be_written_are_known_beforehand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("x")
    with pytest.raises(RotaError, match="is a folder"):
        require_writable(tmp_path)
    with pytest.raises(RotaError, match="there is no folder"):
        require_writable(tmp_path / "a" / "b")
    with pytest.raises(RotaError, match="is no folder"):
        require_writable(tmp_path / "file" / "b")
    with pytest.raises(RotaError, match="is a file; the path of a folder"):
        require_writable_folder(tmp_path / "file")
    with pytest.raises(RotaError, match="there is no folder"):
        require_writable_folder(tmp_path / "a" / "b")
    require_writable(tmp_path / "new")
    require_writable_folder(tmp_path / "new")
    monkeypatch.setattr(atomic_write.os, "access", lambda *_: False)
    for refuse in (require_writable, require_writable_folder):
        with pytest.raises(RotaError, match="no permission to write"):
            refuse(tmp_path / "new")


def test_names_are_as_long_as_files_can_have_and_no_longer(tmp_path: Path) -> None:
    for name in ("\U0001f916" * 62 + ".json", "a." + "b" * 250):
        write_atomically(tmp_path / name, "x")
        assert (tmp_path / name).read_text() == "x"
    with pytest.raises(RotaError, match=r"a file name of 256 bytes; at most 255 are allowed"):
        require_writable(tmp_path / ("c" * 256))
