"""How large the house is, and how long its tests take; ``python -m benchmarks.house`` prints lines and knobs."""

from __future__ import annotations

import ast
import io
import os
import subprocess
import sys
import time
import tokenize
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from benchmarks.row import Options, Row

PROJECT = Path(__file__).parents[1]
SOURCE = PROJECT / "src" / "rota"
STUDIES = PROJECT / "studies" / "src"
PATROL = SOURCE / "planners" / "patrol"
MOST_LINES = {"src/rota": 64_000, "patrol, sun2019 included": 17_000}
MOST_KNOBS = 250  # of patrol
MOST_FILES = 10  # beside the packages of src/rota
MOST_README = 200  # lines
MOST_PARAMETERS = 8
SUITE_S = 300.0


class Size(NamedTuple):
    """Lines of some files: all, and those that hold code (no blank line, no comment, no docstring)."""

    lines: int
    code: int


def size_of(text: str) -> Size:
    """How long a source is."""
    skipped = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER)
    rows: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in skipped:
            rows.update(range(token.start[0], token.end[0] + 1))
    return Size(len(text.splitlines()), len(rows - docstring_rows(text)))


def docstring_rows(text: str) -> set[int]:
    """The lines of a source that docstrings take."""
    rows: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        holds = isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
        if holds and ast.get_docstring(node, clean=False) is not None:
            first = node.body[0]
            rows.update(range(first.lineno, (first.end_lineno or first.lineno) + 1))
    return rows


def size_below(folder: Path) -> Size:
    """All of a folder."""
    sizes = [size_of(file.read_text()) for file in folder.rglob("*.py")]
    return Size(sum(size.lines for size in sizes), sum(size.code for size in sizes))


def knobs_in(tree: ast.Module) -> int:
    """How many numbers and names of a source may be turned: constants of the module, and fields of settings."""
    knobs = 0
    for node in tree.body:
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            named = [part.id for target in targets for part in ast.walk(target) if isinstance(part, ast.Name)]
            knobs += sum(name.strip("_").isupper() for name in named)
        elif isinstance(node, ast.ClassDef) and "Settings" in f"{node.name} {' '.join(map(ast.unparse, node.bases))}":
            fields = [item for item in node.body if isinstance(item, ast.AnnAssign)]
            knobs += sum("ClassVar" not in ast.unparse(item.annotation) for item in fields)
    return knobs


def read_size(file: Path) -> tuple[int, int]:
    """The lines and knobs of a file."""
    text = file.read_text()
    return len(text.splitlines()), knobs_in(ast.parse(text))


def packages(size_of_file: Callable[[Path], tuple[int, int]] = read_size) -> dict[str, tuple[int, int]]:
    """The lines and knobs of each package of Rota, planners by themselves, and of the studies."""
    sums: dict[str, tuple[int, int]] = {}
    for file in [*SOURCE.rglob("*.py"), *STUDIES.rglob("*.py")]:
        parts = file.relative_to(PROJECT).parts[:-1]
        package = "studies" if parts[0] == "studies" else "/".join(parts[2 : 4 if "planners" in parts else 3]) or "root"
        lines, knobs = sums.get(package, (0, 0))
        more = size_of_file(file)
        sums[package] = lines + more[0], knobs + more[1]
    return dict(sorted(sums.items()))


def many_parameters(folder: Path) -> list[str]:
    """The compiled functions that take more parameters than a reader can keep apart."""
    return [
        node.name
        for file in sorted(folder.rglob("*kernels.py"))
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.FunctionDef)
        and len(node.args.posonlyargs + node.args.args + node.args.kwonlyargs) > MOST_PARAMETERS
    ]


def house(_: Options) -> Iterator[Row]:
    """The sizes that are asked of the source and the README."""
    for (name, most), folder in zip(MOST_LINES.items(), (SOURCE, PATROL), strict=True):
        size = size_below(folder)
        measured = f"{size.lines:,} lines, {size.code:,} of them code"
        yield Row(name, f"at most {most:,} lines", measured, size.lines <= most)
    knobs = packages()["planners/patrol"][1]
    yield Row("knobs of patrol", f"at most {MOST_KNOBS}", str(knobs), knobs <= MOST_KNOBS)
    files = sum(path.is_file() for path in SOURCE.iterdir())
    yield Row("files beside the packages of src/rota", f"at most {MOST_FILES}", str(files), files <= MOST_FILES)
    lines = len((PROJECT / "README.md").read_text().splitlines())
    yield Row("README", f"at most {MOST_README} lines", f"{lines} lines", lines <= MOST_README)
    loose = many_parameters(SOURCE)
    yield Row(f"compiled functions with more than {MOST_PARAMETERS} parameters", "0", str(len(loose)), not loose)


def suite(_: Options) -> Iterator[Row]:
    """The tests that `make test` runs, when all kernels are compiled; those that CI runs besides are not among them."""
    command = [
        sys.executable,
        "-m",
        "pytest",
        "--numprocesses",
        "auto",
        "--dist",
        "worksteal",
        "-m",
        "not slow and not ros",
    ]
    environment = {**os.environ, "PYTHONPATH": str(PROJECT)}
    runs = []
    for _run in range(2):  # the first one compiles
        began_s = time.perf_counter()
        done = subprocess.run(command, cwd=PROJECT, env=environment, capture_output=True, text=True)
        runs.append((time.perf_counter() - began_s, done))
    (cold_s, _first), (wall_s, done) = runs
    told = done.stdout.strip().splitlines()[-1] if done.stdout.strip() else f"exit code {done.returncode}"
    measured = f"{wall_s:.0f} s; {cold_s:.0f} s the time before; {told}"
    yield Row("pytest as make test runs it", f"< {SUITE_S:.0f} s", measured, wall_s < SUITE_S and done.returncode == 0)


def main() -> None:
    """Print each package's lines and knobs, and their sums."""
    sizes = packages()
    for package, (lines, knobs) in sizes.items():
        print(f"{package:<18} {lines:>7,} lines {knobs:>5} knobs")
    print(f"{'all':<18} {sum(size[0] for size in sizes.values()):>7,} lines", end=" ")
    print(f"{sum(size[1] for size in sizes.values()):>5} knobs")


if __name__ == "__main__":
    main()
