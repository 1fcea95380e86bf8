# ruff: noqa: E501 (odd values read best side by side)
"""Faulty missions, each from its seed: the examples with a few things changed, in their text, values, bytes and images.

A mission is a folder of files: its own, and the GeoJSON file or ROS map that it names. Any of them may be changed.
"""

from __future__ import annotations

import copy
import json
import random
import re
import struct
import zlib
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

from benchmarks.missions import EXAMPLES, example_missions
from rota.files.yaml_text import parse_text

Files = dict[str, bytes]
Place = tuple[str | int, ...]

NUMBERS = (
    "0", "-0", "-1", "1e-320", "5e-324", "-2.5e-7", "1e7", "1.0000001e7", "1e9", "1e19", "1e155", "1.8e308", "1e400",
    "-1e400", "9" * 30, "-" + "9" * 320, "0x1F", "0x" + "e" * 300, "0o17", "0o" + "7" * 500, "0b101", "0x1p3", "1_000", "+.5",
    "5.", ".5e", "1e", "--3", "1,5", "NaN", ".nan", "-.inf", ".Inf", "Infinity", "1:30", "12:30:45", "٣", "４", "½", "1e+", "²",
)  # fmt: skip
WORDS = (
    "null", "~", "", "yes", "No", "TRUE", "fewest", "every_point", "''", '""', '"', "'", "!!float 3", '!!int "3"',
    "!!str 3", "!!map {}", "!!python/name:os.system x", "!local 3", "&x 3", "*x", "<<", "- ", "? ", ": ", "# ", "%YAML 1.2",
    "---", "...", "|\n  text", ">-\n  folded", "2024-02-30", "@at", "`tick`", "\t", "\u2028", "\u00a0", "\ufeff", "\u202eabc",
    "e\u0301", "\U0001f916", '"\\ud83e\\udd16"', '"\\ud800"', '"\\u0000"', '"\\U00110000"', '"\\x7f"', "a" * 300, "{" * 40,
    "[" * 3000, "[" * 50 + "]" * 50, "{a: " * 200, "..", "/", "/dev/null", "//host/share", "a/../b", "%00", "$(id)", "{}", "[]",
)  # fmt: skip
VALUES: tuple[Any, ...] = (
    None, True, False, 0, 1, -1, 2.5, 1e-9, 1e6, 1e7, 1e12, 1e155, 2**53, 2**63, 2**64, -(2**70), float("inf"), float("nan"),
    "", "0", "1e3", "nan", "metres", "wgs84", "area", "\x00", "\ud800", "n" * 260, "a.b[0]", [], {}, [[]], [[[]]], [0], [0, 0],
    [0, 0, 0], [[0, 0], [1, 0], [0, 1]], [[0, 0], [1e-9, 0], [0, 1e-9]], [[0, 0], [9, 9], [9, 0], [0, 9]], {"": 0}, {"ring": []},
    {"box": [[0, 0], [0, 0]]}, {"points": []}, {"circle": {"centre": [0, 0], "radius_m": 1e7}}, {"geojson": "mission.yaml"},
    {"shape": "disc", "radius_m": 1e-3}, {"shape": "square", "side_m": 1e7}, {"map": "mission.yaml", "inside": [0, 0]},
    {"text": "..#", "cell_m": 1e7}, {"text": "#", "cell_m": 1}, {"outer": [[0, 0], [9, 0], [0, 9]], "holes": [[[1, 1], [2, 1], [1, 2]]]},
)  # fmt: skip


def mutated(seed: int) -> tuple[str, Files]:
    """The name of the mission's file and all files of the mission of this seed: always the same."""
    rng = random.Random(seed)
    stem = rng.choice(sorted(bases()))
    files, main = dict(bases()[stem]), "mission.yaml"
    if rng.random() < 0.25 and not _is_odd(files[main]):
        files["mission.json"] = json.dumps(parse_text(files.pop(main).decode(), main, "").value).encode()
        main = "mission.json"
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        name = main if rng.random() < 0.6 else rng.choice(sorted(files))
        kinds = _CHANGES_OF_IMAGES if name.endswith((".png", ".pgm")) else _CHANGES_OF_TEXT
        files[name] = rng.choice(kinds)(rng, files[name], name)
    return main, files


@cache
def bases() -> dict[str, Files]:
    """The examples with the files that they name, and some with other kinds of maps."""
    found: dict[str, Files] = {}
    for path in example_missions():
        text = path.read_bytes()
        named = re.findall(rb"[\w.]+\.(?:geojson|yaml)", re.sub(rb"#.*", b"", text))
        found[path.stem] = {"mission.yaml": text} | {
            name: (EXAMPLES / name).read_bytes() for name in map(bytes.decode, named)
        }
    room = b"P5\n# a room\n12 10\n255\n" + bytes(
        254 if 0 < x < 11 and 0 < y < 9 else 0 for y in range(10) for x in range(12)
    )
    plain = b"P2 12 10 15\n" + b"\n".join(
        b" ".join(b"15" if 0 < x < 11 else b"0" for x in range(12)) for _ in range(10)
    )
    sheet = b"image: room.pgm\nresolution: 0.5\norigin: [-1, -2, 0.3]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n"
    mission = found["building"]["mission.yaml"].replace(b"[12.0, 8.0]", b"[0.5, 1.5]").replace(b"building_map", b"room")
    for kind, image in (("binary", room), ("plain", plain)):
        found[f"room-{kind}"] = {"mission.yaml": mission, "room.yaml": sheet, "room.pgm": image}
    found["building"]["building_map.png"] = (EXAMPLES / "building_map.png").read_bytes()
    return found


# ---------------------------------------------------------------- text and bytes


def _is_odd(data: bytes) -> bool:
    return not data.isascii()


def _other_token(rng: random.Random, data: bytes, _name: str) -> bytes:
    """A number or word of the text written as something else."""
    text = data.decode("utf-8", "replace")
    tokens = list(re.finditer(r"-?\d[\d.e+-]*|[A-Za-z_]\w*", text))
    if not tokens:
        return data
    token = rng.choice(tokens)
    is_number = token[0][0] in "-0123456789"
    other = rng.choice(NUMBERS if is_number and rng.random() < 0.8 else WORDS)
    return (text[: token.start()] + other + text[token.end() :]).encode("utf-8", "surrogatepass")


def _other_bytes(rng: random.Random, data: bytes, _name: str) -> bytes:
    """Bytes cut off, left out, doubled, turned over or put in."""
    at, count = rng.randrange(len(data) + 1), rng.choice((1, 1, 2, 8, 64))
    junk = rng.choice(
        (rng.randbytes(count), b"\x00" * count, b"\xff\xfe", b"\xed\xa0\x80", b"\xc3", b"\x1b[2J", b"\x85")
    )
    return rng.choice(
        (
            data[:at],
            data[:at] + data[at + count :],
            data[:at] + data[at : at + count] * rng.choice((2, 50)) + data[at + count :],
            data[:at] + junk + data[at:],
            data[:at] + junk + data[at + len(junk) :],
        )
    )


def _other_encoding(rng: random.Random, data: bytes, _name: str) -> bytes:
    """A byte order mark, another encoding, other ends of lines."""
    text = data.decode("utf-8", "replace")
    ends = rng.choice(("\n", "\r\n", "\r", "\x85", "\u2028", "\n\n", "\t\n"))
    encoding = rng.choice(("utf-8", "utf-8-sig", "utf-16", "utf-16-be", "utf-32", "cp037", "utf-7"))
    return rng.choice((b"", b"", b"\xef\xbb\xbf", b"\xfe\xff")) + text.replace("\n", ends).encode(encoding, "replace")


def _other_lines(rng: random.Random, data: bytes, _name: str) -> bytes:
    """Lines doubled, swapped, indented or joined: keys given twice, blocks in the wrong place."""
    lines = data.split(b"\n")
    a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
    kind = rng.randrange(5)
    if kind == 0:
        lines.insert(b, lines[a])
    elif kind == 1:
        lines[a], lines[b] = lines[b], lines[a]
    elif kind == 2:
        lines[a] = rng.choice((b" ", b"\t", b"      ", b"- ")) + lines[a]
    elif kind == 3:
        lines[a : a + 2] = [b" ".join(lines[a : a + 2])]
    else:
        lines.insert(
            a, rng.choice((b"---", b"...", b"%YAML 1.1", b"%TAG ! x", b"%YAML 3.0", b"&a", b"? x", b"<<: *a", b"\x0c"))
        )
    return b"\n".join(lines)


# ---------------------------------------------------------------- values


def _other_value(rng: random.Random, data: bytes, name: str) -> bytes:
    """A value of another kind or size, a key left out, renamed or added, at any place of the file."""
    tree = _tree(data, name)
    spots = list(places(tree))
    if not spots:
        return data
    *outer, last = rng.choice(spots)
    block = tree
    for step in outer:
        block = block[step]
    _CHANGES_OF_VALUES[rng.randrange(len(_CHANGES_OF_VALUES))](rng, block, last)
    text = json.dumps(tree, ensure_ascii=rng.random() < 0.5)
    if not name.endswith("json"):
        text = text.replace("NaN", ".nan").replace("Infinity", ".inf")
    return text.encode("utf-8", "surrogatepass")


def _tree(data: bytes, name: str) -> Any:
    try:
        return parse_text(data.decode(), name, "").value
    except Exception:  # changed before to what nothing can read
        return {"rota": 1, "area": [[0, 0], [9, 0], [9, 9]]}


def places(value: Any, place: Place = ()) -> Iterator[Place]:
    """Every place in a tree of lists and mappings."""
    if place:
        yield place
    inner = value.items() if isinstance(value, dict) else enumerate(value if isinstance(value, list) else [])
    for step, part in inner:
        yield from places(part, (*place, step))


def _replace(rng: random.Random, block: Any, key: Any) -> None:
    block[key] = copy.deepcopy(rng.choice(VALUES))


def _resize(rng: random.Random, block: Any, key: Any) -> None:
    """A number times a power of ten, its sign turned, or its last digits changed; a list longer, shorter, turned."""
    value = block[key]
    if isinstance(value, int | float) and not isinstance(value, bool):
        block[key] = rng.choice(
            (value * 10.0 ** rng.randrange(-12, 13), -value, value + 1e-9, value * (1 + 2**-52), value // 1)
        )
    elif isinstance(value, list):
        kinds = (
            value[::-1],
            value[:1],
            value[:-1],
            value * 2,
            value * rng.choice((3, 300)),
            value + value[:1],
            [value],
            sorted(value, key=str),
        )
        block[key] = copy.deepcopy(rng.choice(kinds))
    elif isinstance(value, str):
        block[key] = rng.choice(
            (value.upper(), value + " ", value * 200, value[:-1], f"../{value}", value + "\n", value[::-1])
        )
    else:
        _replace(rng, block, key)


def _remove(_rng: random.Random, block: Any, key: Any) -> None:
    del block[key]


def _rename(rng: random.Random, block: Any, key: Any) -> None:
    if isinstance(block, dict):
        block[
            rng.choice((key.upper(), key + "s", key[:-1], f" {key}", key + "\x00", "\ud801", "", "name", "k" * 5000))
        ] = block.pop(key)
    else:
        block.insert(key, copy.deepcopy(block[key]))


def _nest(rng: random.Random, block: Any, key: Any) -> None:
    value = block[key]
    for _ in range(rng.choice((1, 2, 30, 400))):
        value = rng.choice(([value], {"ring": value}, {"outer": value}))
    block[key] = value


def _swap(rng: random.Random, block: Any, key: Any) -> None:
    other = rng.choice(list(block) if isinstance(block, dict) else range(len(block)))
    block[key], block[other] = copy.deepcopy(block[other]), block[key]


_CHANGES_OF_VALUES: tuple[Callable[[random.Random, Any, Any], None], ...] = (
    _replace, _replace, _replace, _resize, _resize, _remove, _rename, _nest, _swap,
)  # fmt: skip


# ---------------------------------------------------------------- images


def _other_header(rng: random.Random, data: bytes, _name: str) -> bytes:
    """Sizes, depths and kinds that the pixels do not have; in PNG files with the right checksums."""
    if not data.startswith(b"\x89PNG") or len(data) < 33:
        at = rng.choice([found.start() for found in re.finditer(rb"\d+", data[:40])] or [0])
        end = at + len(re.match(rb"\d*", data[at:])[0])  # type: ignore[index]
        sizes = (
            b"0",
            b"1",
            b"65535",
            b"65536",
            b"99999999",
            b"4294967297",
            b"-3",
            b"1.5",
            b"9" * 400,
            b"",
            b"0x10",
            b"12#",
        )
        return data[:at] + rng.choice(sizes) + data[end:]
    header = list(struct.unpack(">IIBBBBB", data[16:29]))
    k = rng.randrange(7)
    header[k] = rng.choice((0, 1, 7, 30000, 2**31 - 1, 2**32 - 1) if k < 2 else (0, 1, 2, 3, 4, 6, 8, 16, 99, 255))
    body = b"IHDR" + struct.pack(">IIBBBBB", *header)
    return data[:12] + body + struct.pack(">I", zlib.crc32(body)) + data[33:]


def _other_chunks(rng: random.Random, data: bytes, _name: str) -> bytes:
    """Chunks of a PNG file added or put in another order; a PGM file with other pixels."""
    if not data.startswith(b"\x89PNG"):
        return data[: rng.randrange(len(data) + 1)] + rng.choice(
            (b"# \n", b"999999 ", b"1e3 ", b"\xb2 ", b" " * 99, b"1_0 ", b"+5 ")
        )
    kinds = (b"tRNS", b"PLTE", b"acTL", b"iCCP", b"zTXt", b"IDAT", b"IEND", b"gAMA", b"eXIf", b"caBX")
    payload = rng.choice(
        (b"", b"\x00", rng.randbytes(9), b"k\x00\x00" + zlib.compress(b"\x00" * 3_000_000), zlib.compress(b""))
    )
    body = rng.choice(kinds) + payload
    chunk = struct.pack(">I", len(payload)) + body + struct.pack(">I", zlib.crc32(body))
    return data[:33] + chunk + data[33:]


_CHANGES_OF_TEXT = (
    _other_token,
    _other_token,
    _other_value,
    _other_value,
    _other_value,
    _other_lines,
    _other_bytes,
    _other_encoding,
)
_CHANGES_OF_IMAGES = (_other_header, _other_header, _other_chunks, _other_bytes)
