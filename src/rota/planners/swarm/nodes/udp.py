"""Datagrams over UDP: each robot has a port of its own, to which all others and nobody else should send."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress

from rota.errors import LinkError, MissionError
from rota.planners.swarm.nodes.telling import SIZE
from rota.planning.robot_processes import LAST_PORT, ProcessSettings, is_loopback

MOST_AT_ONCE = 4096  # datagrams read at a time, so that no flood of them keeps a robot from deciding
BUFFER_BYTES = 1 << 20

Address = tuple[str, int]


def addresses_of(settings: ProcessSettings, robots: int) -> tuple[Address, ...]:
    """Where each robot of a fleet listens and, last, where the recorder does; MissionError for too few hosts, ports."""
    hosts = settings.hosts * (robots + 1) if len(settings.hosts) == 1 else settings.hosts
    if len(hosts) != robots + 1:
        raise MissionError(
            f"hosts: {len(hosts)} is not allowed; give one, or one for each of the {robots} robots and the recorder's"
        )
    if settings.port + robots > LAST_PORT:
        raise MissionError(
            f"port: {settings.port} is not allowed: {robots} robots and a recorder need ports up to {LAST_PORT};"
            f" {LAST_PORT - robots} is the last"
        )
    return tuple((host, settings.port + k) for k, host in enumerate(hosts))


def clock_of(addresses: Sequence[Address]) -> Callable[[], int]:
    """The clock in nanoseconds that all share: on one machine the one that nobody sets, else that of the day."""
    return time.monotonic_ns if all(is_loopback(host) for host, _ in addresses) else time.time_ns


class UdpPort:
    """A socket that listens at one of the addresses and sends to others; raises LinkError where it cannot listen."""

    def __init__(self, own: Address, others: Sequence[Address]) -> None:
        self._others = tuple(others)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind(own)
        except OSError as error:
            self._socket.close()
            raise LinkError(
                f"{own[0]}:{own[1]}: cannot listen there ({error.strerror}); is this robot running already? Another"
                " port is chosen by --port"
            ) from None
        self._socket.setblocking(False)
        with suppress(OSError):
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)

    def receive(self) -> Iterator[bytes]:
        """What has arrived, at most ``MOST_AT_ONCE``; of longer datagrams so much that their length tells them."""
        for _ in range(MOST_AT_ONCE):
            try:
                yield self._socket.recv(SIZE + 1)
            except BlockingIOError:
                return
            except OSError:  # what a system says of a datagram that somebody did not take
                continue

    def send(self, datagram: bytes) -> None:
        """Send to all others; what cannot be sent is lost, as on any way."""
        for address in self._others:
            with suppress(OSError):
                self._socket.sendto(datagram, address)

    def close(self) -> None:
        """Let go of the port."""
        self._socket.close()
