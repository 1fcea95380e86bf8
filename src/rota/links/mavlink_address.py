"""The addresses of MAVLink vehicles, as MAVSDK writes them."""

from __future__ import annotations

import re

from rota.errors import RotaError

_WITH_PORT = re.compile(r"(udpin|udpout|tcpin|tcpout)://(.+):(\d{1,5})")
LAST_PORT = 65535


def addresses(text: str, count: int) -> list[str]:
    """An address for each of ``count`` vehicles: those in ``text``, or its only one and the ports after it.

    Raises RotaError for another number of addresses, for two that are the same, and for ports that do not exist.
    """
    given = text.split("+")
    if len(given) == 1 and count > 1:
        match = _WITH_PORT.fullmatch(text)
        if match is None or int(match[3]) + count - 1 > LAST_PORT:
            raise RotaError(
                f"mavlink.address: {text!r} is not allowed for {count} robots; such as udpin://127.0.0.1:14540 is"
                f" needed, with {count} ports from there on, or {count} addresses with + between"
            )
        kind, host, port = match.groups()
        return [f"{kind}://{host}:{int(port) + k}" for k in range(count)]
    if len(given) != count:
        raise RotaError(f"mavlink.address: {len(given)} addresses are given; {count} are needed, one for each robot")
    if len(set(given)) < count:
        raise RotaError(f"mavlink.address: {text!r} is not allowed; every robot needs an address of its own")
    if not all(address.strip() for address in given):
        raise RotaError(f"mavlink.address: {text!r} is not allowed; an address is empty")
    return given
