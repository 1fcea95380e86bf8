"""Files appear whole or not at all: a crash leaves the old file or none, never half of one."""

from __future__ import annotations

import os
import secrets
import stat
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from rota.errors import RotaError

LONGEST_NAME = 255  # bytes of a file's name that common file systems take


def write_atomically(path: str | os.PathLike[str], text: str) -> None:
    """Write ``text`` (UTF-8) to ``path`` by way of ``replaced_file``; raises RotaError as that does."""
    with replaced_file(path) as partial:
        partial.write_text(text, encoding="utf-8", newline="\n")


@contextmanager
def replaced_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary file beside ``path`` that is brought to the disk and takes its place when the block ends well.

    Otherwise it disappears. A link is followed. What is no regular file (a pipe, /dev/stdout) cannot be replaced: the
    block gets the path itself. An existing file keeps its permissions. Raises RotaError when it cannot be written.
    """
    require_writable(path)
    target = Path(os.path.realpath(path))
    try:
        if target.exists() and not target.is_file():
            yield target
            return
        stem = os.fsdecode(os.fsencode(target.stem)[:100])  # which need not be UTF-8
        partial = target.with_name(f".{stem}.{secrets.token_hex(4)}.part{target.suffix[:20]}")
        try:
            # made like any other new file, so that it gets the same permissions
            partial.touch(exist_ok=False)
            yield partial
            _settle(partial, target)
        finally:
            partial.unlink(missing_ok=True)
    except OSError as error:
        raise RotaError(f"{path}: cannot be written: {error.strerror or error}") from error


@contextmanager
def replaced_folder(path: str | os.PathLike[str], known: Callable[[str], bool]) -> Iterator[Path]:
    """A place for a new folder of the same name, which takes the place of ``path`` when the block ends well.

    Otherwise it disappears. A folder that is there already is replaced if it holds only files whose names are
    ``known``. Raises RotaError for another, and when it cannot be written.
    """
    require_writable_folder(path)
    target = Path(os.path.realpath(path))
    require_short_names([target.name])
    try:
        others = [entry.name for entry in sorted(target.iterdir()) if not known(entry.name)] if target.exists() else []
        if others:
            raise RotaError(f"{path}: holds {others[0]!r}, which would be lost; name another folder")
        with tempfile.TemporaryDirectory(prefix=".rota.", suffix=".part", dir=target.parent) as aside:
            partial = Path(aside) / "new" / target.name
            partial.parent.mkdir()
            yield partial
            for file in partial.iterdir():
                _bring_to_disk(file)
            if target.exists():
                os.replace(target, Path(aside) / "old")
            os.replace(partial, target)
            _sync_folder(target.parent)
    except OSError as error:
        raise RotaError(f"{path}: cannot be written: {error.strerror or error}") from error


def _bring_to_disk(file: Path) -> None:
    with file.open("rb") as opened:
        os.fsync(opened.fileno())


def _settle(partial: Path, target: Path) -> None:
    """Bring a finished file to the disk and give it its name."""
    _bring_to_disk(partial)
    if target.exists():
        os.chmod(partial, stat.S_IMODE(target.stat().st_mode))
    os.replace(partial, target)
    _sync_folder(target.parent)


def _sync_folder(folder: Path) -> None:
    """Bring a rename in the folder to the disk where the file system allows it."""
    # the rename itself must reach the disk too; not every file system lets a folder be opened
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except OSError:
        return
    try:
        os.fsync(descriptor)
    except OSError:
        pass
    finally:
        os.close(descriptor)


def require_suffix(path: str | os.PathLike[str], allowed: tuple[str, ...], what: str) -> str:
    """The suffix of ``path`` in lower case; raises RotaError when it is none of ``allowed`` for ``what``."""
    suffix = Path(path).suffix
    if suffix.lower() not in allowed:
        given = f"{suffix!r} is no format for {what}" if suffix else f"has no suffix, which tells the format of {what}"
        needed = " or ".join([", ".join(allowed[:-1]), allowed[-1]] if len(allowed) > 1 else allowed)
        raise RotaError(f"{path or 'an empty path'}: {given}; {needed} is needed")
    return suffix.lower()


def require_writable(path: str | os.PathLike[str]) -> None:
    """Raise RotaError when it is already known that no file can be written at ``path``.

    To be asked before long work: whether the folder exists and can be written to, and whether ``path`` is a folder.
    """
    target = Path(os.path.realpath(path))
    folder = target.parent
    if not str(path):
        raise RotaError("an empty path cannot be written to; a file name is needed")
    require_short_names([target.name])
    if target.is_dir():
        raise RotaError(f"{path}: is a folder; the path of a file is needed")
    if not folder.exists():
        raise RotaError(f"{path}: there is no folder {folder}; create it first")
    if not folder.is_dir():
        raise RotaError(f"{path}: {folder} is no folder")
    replaceable = os.access(folder, os.W_OK | os.X_OK) and (not target.exists() or os.access(target, os.W_OK))
    if not replaceable and not (target.exists() and not target.is_file()):
        what = target if target.exists() and os.access(folder, os.W_OK) else folder
        raise RotaError(f"{path}: cannot be written: no permission to write to {what}")


def require_short_names(names: Iterable[str]) -> None:
    """Raise RotaError for names of files that are longer than file systems take."""
    for name in names:
        count = len(os.fsencode(name))
        if count > LONGEST_NAME:
            raise RotaError(f"{name[:40]}...: a file name of {count} bytes; at most {LONGEST_NAME} are allowed")


def require_target(path: str | os.PathLike[str], source: str | os.PathLike[str] | None) -> None:
    """Raise RotaError like ``require_writable``, and when ``path`` is the file ``source`` that is to be read."""
    require_writable(path)
    if source is not None and os.path.exists(source) and os.path.exists(path) and os.path.samefile(source, path):
        raise RotaError(f"{path}: is the input itself and is not overwritten; name another file")


def require_writable_folder(path: str | os.PathLike[str]) -> None:
    """Raise RotaError when it is already known that no folder can be made or filled at ``path``."""
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_dir():
        raise RotaError(f"{path}: is a file; the path of a folder is needed")
    nearest = target if target.is_dir() else target.parent
    if not nearest.exists():
        raise RotaError(f"{path}: there is no folder {nearest}; create it first")
    if not nearest.is_dir():
        raise RotaError(f"{path}: {nearest} is no folder")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise RotaError(f"{path}: cannot be written: no permission to write to {nearest}")
