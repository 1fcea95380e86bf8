"""An environment of its own for a package that is measured beside Rota, thrown away with the folder it is in."""

from __future__ import annotations

import json
import sys
import venv
from pathlib import Path
from typing import Any

from benchmarks.shell import run


def peer_answer(folder: Path, requirement: str, program: str, problem: dict[str, Any]) -> dict[str, Any] | str:
    """What ``program`` (a file beside this one) prints for the problem, both as JSON, or why there is no answer.

    requirement: what to install for it, as pip understands it. The environment is made once in a folder and used again.
    """
    python = peer_python(folder, requirement, program)
    if isinstance(python, str):
        return python
    file = folder / f"{Path(program).stem}-problem.json"
    file.write_text(json.dumps(problem))
    # -I: without the paths by which this project is found
    answered = run([python, "-I", Path(__file__).with_name(program), file])
    return json.loads(answered.out) if answered.code == 0 else answered.failure()


def peer_python(folder: Path, requirement: str, program: str) -> Path | str:
    """The interpreter of the environment for ``program``, made where there is none; or why it cannot be made."""
    environment = folder / Path(program).stem
    python = environment / ("Scripts" if sys.platform == "win32" else "bin") / "python"
    if not python.exists():
        venv.create(environment, with_pip=True)
        installed = run([python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", requirement])
        if installed.code != 0:
            return f"{requirement} cannot be installed: {installed.failure()}"
    return python
