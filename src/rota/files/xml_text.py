"""XML documents as text, with names in them that no XML could hold."""

from __future__ import annotations

import re
from xml.etree import ElementTree

# XML 1.0, section 2.2: no character reference can stand for these either
_NO_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def allowed_text(text: str) -> str:
    """The text with U+FFFD for characters that XML cannot hold (most control characters).

    All others are escaped where the document is written.
    """
    return _NO_XML.sub("\ufffd", text)


def child(parent: ElementTree.Element, tag: str, text: str | None = None, **attributes: str) -> ElementTree.Element:
    """A new last child of ``parent``."""
    element = ElementTree.SubElement(parent, tag, attributes)
    if text is not None:
        element.text = allowed_text(text)
    return element


def decimal_text(value: float) -> str:
    """A finite float with all its digits and without an exponent, which xsd:decimal does not take.

    Numbers below 1e-4 have 15 decimals.
    """
    text = repr(value)
    return text if "e" not in text else f"{value:.15f}"


def xml_text(root: ElementTree.Element) -> str:
    """The document with its declaration, indented."""
    ElementTree.indent(root, " ")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ElementTree.tostring(root, encoding="unicode")}\n'
