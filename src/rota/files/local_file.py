"""Files that a mission consists of: finding and reading them."""

from __future__ import annotations

from pathlib import Path

from rota.errors import MissionError


def read_bytes(path: Path, what: str) -> bytes:
    """The bytes of a file; ``what`` names its role in errors. Raises MissionError when it cannot be read."""
    try:
        if not path.is_dir():
            return path.read_bytes()
    except FileNotFoundError:
        raise MissionError(f"{path}: no such file; {what} is needed") from None
    except (OSError, ValueError) as error:
        raise MissionError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    raise MissionError(f"{path}: is a folder; {what} is needed")


def read_text(path: Path, what: str) -> str:
    """The text of a UTF-8 file, with or without a byte order mark. Raises MissionError as ``read_bytes`` does."""
    data = read_bytes(path, what)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        column = error.start - data.rfind(b"\n", 0, error.start)
        byte = data[error.start]
        raise MissionError(f"{path}:{line}:{column}: byte 0x{byte:02x} is not UTF-8; save the file as UTF-8") from None


def local_file(folder: Path, name: str, *, confine_to: Path | None) -> Path:
    """The path of a file named in one that lies in ``folder``.

    Raises MissionError when it leaves the folder ``confine_to`` (None: it may), symbolic links followed.
    """
    path = folder / name
    if confine_to is not None:
        try:
            inside = "\0" not in name and path.resolve().is_relative_to(confine_to.resolve())
        except (OSError, RuntimeError):  # a name that is too long, or links in a circle
            raise MissionError(f"{name!r} cannot be followed; a file in the mission's folder is needed") from None
        if not inside:
            raise MissionError(f"{name!r} leaves the mission's folder; only files inside it may be named")
    return path
