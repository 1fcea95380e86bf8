"""The sources of the house, each read and looked through once for all tests that judge them."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

from benchmarks.house import knobs_in

import rota
import rota_studies

SOURCE, STUDIES = Path(rota.__file__).parent, Path(rota_studies.__file__).parent
FILES = [*sorted(SOURCE.rglob("*.py")), *sorted(STUDIES.rglob("*.py"))]
PLANNERS = ("patrol", "swarm", "bounce")
TELLING = {
    ast.Import, ast.ImportFrom, ast.Call, ast.FunctionDef, ast.AsyncFunctionDef, ast.Compare, ast.MatchValue,
    ast.Attribute,
}  # fmt: skip


class Function(NamedTuple):
    """What is said of a function: its name, its lines, whether it is a property, whether it is private and silent."""

    name: str
    lines: int
    is_property: bool
    is_silent: bool


class Source(NamedTuple):
    """What is said of a file."""

    lines: int
    imports: frozenset[str]  # every module that is named in an import, at whatever depth, relative ones resolved
    functions: tuple[Function, ...]  # methods and those within others too
    branches: tuple[int, ...]  # the lines that ask for a planner by its name or by the type of its settings
    knobs: int


@cache
def source_of(file: Path) -> Source:
    """What is said of a file of the house."""
    return source_in(file.read_text(), module_name(file), is_package=file.name == "__init__.py")


def source_in(text: str, module: str = "", *, is_package: bool = False) -> Source:
    """What is said of a text that is to be this module."""
    tree = ast.parse(text)
    imports: set[str] = set()
    functions: list[Function] = []
    branches: list[int] = []
    for node in nodes_in(tree):
        if type(node) not in TELLING:  # most nodes
            continue
        imports.update(_imports_at(node, module, is_package))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            is_property = any("property" in ast.unparse(each) for each in node.decorator_list)
            lines = (node.end_lineno or 0) - node.lineno + 1
            functions.append(Function(node.name, lines, is_property, is_silent(node)))
        elif _asks_for_planner(node):
            branches.append(node.lineno)
    return Source(len(text.splitlines()), frozenset(imports), tuple(functions), tuple(branches), knobs_in(tree))


def nodes_in(tree: ast.AST) -> Iterator[ast.AST]:
    """All nodes of a tree, as ``ast.walk`` has them, in a third of its time."""
    todo = [tree]
    while todo:
        node = todo.pop()
        yield node
        for part in vars(node).values():
            if isinstance(part, list):
                todo.extend(each for each in part if isinstance(each, ast.AST))
            elif isinstance(part, ast.AST):
                todo.append(part)


def module_name(file: Path) -> str:
    """How a file of the house is imported."""
    home = SOURCE if file.is_relative_to(SOURCE) else STUDIES
    parts = file.relative_to(home.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def is_silent(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """Whether it is a private function of ten lines or more without a docstring."""
    private = re.match("_[^_]", function.name) is not None
    return private and (function.end_lineno or 0) - function.lineno >= 9 and ast.get_docstring(function) is None


def _imports_at(node: ast.AST, module: str, is_package: bool) -> Iterable[str]:
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        base = node.module or ""
        if node.level:
            parts = module.split(".")
            kept = parts[: len(parts) - node.level + is_package]
            base = ".".join([*kept, *([node.module] if node.module else [])])
        return [base, *(f"{base}.{alias.name}" for alias in node.names)]
    if isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
        called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if called in ("import_module", "__import__"):
            return [str(node.args[0].value)]
    return ()


def _asks_for_planner(node: ast.AST) -> bool:
    if isinstance(node, ast.Compare | ast.MatchValue):
        return any(isinstance(part, ast.Constant) and part.value in PLANNERS for part in ast.walk(node))
    if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("isinstance", "issubclass"):
        return any(name.endswith("Settings") and name != "Settings" for name in _names_in(node.args[1]))
    return isinstance(node, ast.Attribute) and node.attr in PLANNERS


def _names_in(node: ast.AST) -> Iterator[str]:
    for part in ast.walk(node):
        yield getattr(part, "id", getattr(part, "attr", ""))
