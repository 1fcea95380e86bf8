"""Names of files that browsers told: plain ones, which lead nowhere."""

from __future__ import annotations

import re
from pathlib import PurePosixPath

from rota.web.refusal import Refusal

_NAME = re.compile(r"[\w\-+ ()\[\]&,=@#%~][\w\-+ .()\[\]&,=@#%~]{0,99}")
_DEVICE = re.compile(r"(?i)(con|prn|aux|nul|com\d|lpt\d)(\..*)?")


def safe_name(name: str) -> str:
    """The last part of a file's name as a browser told it; Refusal for one that is no plain name."""
    last = PurePosixPath(name.replace("\\", "/")).name
    if not _NAME.fullmatch(last) or _DEVICE.fullmatch(last) or last.endswith((" ", ".")):
        raise Refusal(400, f"{last[:100]!r} is not allowed as a file's name; letters, digits, blanks and -_.+ are")
    return last
