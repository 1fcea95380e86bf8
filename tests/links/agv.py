"""A simulated VDA 5050 vehicle, and Debian's mosquitto on loopback: all that is sent keeps the official schemas."""

from __future__ import annotations

import asyncio
import getpass
import json
import math
import shutil
import socket
import subprocess
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import AsyncExitStack, asynccontextmanager, contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from aiomqtt import Client, MqttError, Will
from vda5050.validation.schema_validator import SchemaValidator

from rota.links.vda5050_broker import end_task

Json = dict[str, Any]
# of version 2.1, as vda5050-sdk holds them; of 3.0.0 from github.com/VDA5050/VDA5050, less commas that are no JSON
SCHEMAS, SCHEMAS_3 = SchemaValidator(), SchemaValidator(Path(__file__).parent / "vda5050_3")
TELLS_S = 0.2  # between states of one that really drives
STEP_S = 0.02  # in which it drives from one node to the next


@dataclass(frozen=True, kw_only=True)
class Ways:
    """How a vehicle is special.

    keeps: how many nodes of an order it keeps at most. loses: the order update that never arrives the first time.
    refuses_update: the one that it does not take. real: it drives at the speeds of the order's edges and does its
    waits, and does not hop from node to node. version: what it speaks; it takes no message of another one.
    """

    refuses: bool = False
    deaf: bool = False
    keeps: int | None = None
    map_id: str = "map"
    automatic: bool = True
    cannot_pause: bool = False
    dies_at: int | None = None
    loses: int | None = None
    refuses_update: int | None = None
    real: bool = False
    version: str = "2.1.0"
    factsheet: Json | None = None


@dataclass
class Agv:
    """A vehicle that passes a released node every ``STEP_S``; ``passed`` are the places of all of them.

    told: the actions of all nodes that it has been given.
    """

    serial: str
    ways: Ways = field(default_factory=Ways)
    place: tuple[float, float] = (0.0, 0.0)
    order: Json | None = None
    nodes: list[Json] = field(default_factory=list)
    edges: list[Json] = field(default_factory=list)
    last: Json = field(default_factory=lambda: {"nodeId": "", "sequenceId": 0})
    actions: dict[str, str] = field(default_factory=dict)
    errors: list[Json] = field(default_factory=list)
    paused: bool = False
    passed: list[tuple[float, float]] = field(default_factory=list)
    taken: list[str] = field(default_factory=list)
    told: list[Json] = field(default_factory=list)
    waits_s: float = 0.0
    told_s: float = 0.0
    headers: int = 0
    dead: bool = False
    waits_for_trigger: str = ""

    @property
    def is_3(self) -> bool:
        return self.ways.version.startswith("3.")

    def topic(self, name: str) -> str:
        return f"uagv/v{self.ways.version[0]}/rota/{self.serial}/{name}"

    async def run(self, client: Client) -> None:
        await client.subscribe(self.topic("order"))
        await client.subscribe(self.topic("instantActions"))
        await client.publish(self.topic("connection"), json.dumps(self.connection("ONLINE")), qos=1, retain=True)
        driving = asyncio.create_task(self.drive(client))
        try:
            async for message in client.messages:
                if self.ways.deaf or self.dead:
                    continue
                name = message.topic.value.rsplit("/", 1)[1]
                read = json.loads(bytes(message.payload))
                assert (SCHEMAS_3 if self.is_3 else SCHEMAS).errors(name, read) == [], read
                if read["version"] != self.ways.version:
                    about = [("topic", name), ("headerId", str(read["headerId"]))]
                    self.complain("validationError", about, f"{read['version']} is not {self.ways.version}")
                elif name == "order":
                    self.take_order(read)
                else:
                    await self.take_actions(client, read)
                await self.tell(client)
        finally:
            driving.cancel()

    def connection(self, state: str) -> Json:
        told = "CONNECTION_BROKEN" if self.is_3 and state == "CONNECTIONBROKEN" else state
        return {**self.head(), "connectionState": told}

    def head(self) -> Json:
        self.headers += 1
        now = datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
        return {
            "headerId": self.headers,
            "timestamp": now,
            "version": self.ways.version,
            "manufacturer": "rota",
            "serialNumber": self.serial,
        }

    def take_order(self, order: Json) -> None:
        ident = order["orderId"]
        self.taken.append(f"{ident}:{order['orderUpdateId']}")
        if order["orderUpdateId"] == self.ways.loses and self.taken.count(self.taken[-1]) == 1:
            return
        if self.ways.refuses:
            self.complain("orderError", [("orderId", ident)])
            return
        if order["orderUpdateId"] == self.ways.refuses_update:
            self.complain("orderUpdateError", [("orderId", ident)], "too far")
            return
        if self.order is not None and self.order["orderId"] == ident:
            if order["orderUpdateId"] <= self.order["orderUpdateId"]:
                return
            base = [part for part in [*self.nodes, self.last] if part.get("released", True)]
            assert order["nodes"][0]["sequenceId"] == max(part["sequenceId"] for part in base)
            self.nodes = [node for node in self.nodes if node["released"]]
            self.edges = [edge for edge in self.edges if edge["released"]]
            news = order["nodes"][1:]
        else:
            assert not self.nodes, "an order while another one is going on"
            first, *news = order["nodes"]
            self.pass_node(first)
        kept = news if self.ways.keeps is None else news[: self.ways.keeps]
        self.order = order
        self.told += [action for node in news for action in node["actions"]]
        self.nodes += kept
        self.edges += order["edges"][: len(kept)]
        for node in order["nodes"]:
            for action in node["actions"]:
                self.actions.setdefault(action["actionId"], "WAITING")

    def complain(self, kind: str, about: list[tuple[str, str]], text: str | None = None) -> None:
        references = [{"referenceKey": key, "referenceValue": value} for key, value in about]
        told = {} if text is None else {"errorDescription": text}
        self.errors = [{"errorType": kind, "errorLevel": "WARNING", "errorReferences": references, **told}]

    async def take_actions(self, client: Client, message: Json) -> None:
        for action in message["instantActions" if self.ways.version.startswith("2.0") else "actions"]:
            kind, ident = action["actionType"], action["actionId"]
            if ident in self.actions:
                continue
            self.actions[ident] = "FINISHED"
            if kind in ("startPause", "stopPause"):
                if self.ways.cannot_pause and kind == "startPause":
                    self.actions[ident] = "FAILED"
                else:
                    self.paused = kind == "startPause"
            elif kind == "cancelOrder":
                if not self.nodes:
                    self.actions[ident] = "FAILED"
                self.nodes, self.edges = [], []
            elif kind == "factsheetRequest" and self.ways.factsheet is not None:
                await client.publish(self.topic("factsheet"), json.dumps({**self.head(), **self.ways.factsheet}))
            elif kind == "trigger":
                self.actions[self.waits_for_trigger] = "FINISHED"
                self.waits_for_trigger = ""

    def pass_node(self, node: Json) -> None:
        self.last = node
        self.place = (node["nodePosition"]["x"], node["nodePosition"]["y"])
        self.passed.append(self.place)
        for action in node["actions"]:
            waits = action["actionType"] == "waitForTrigger"
            self.actions[action["actionId"]] = "RUNNING" if waits else "FINISHED"
            if waits:
                self.waits_for_trigger = action["actionId"]

    async def drive(self, client: Client) -> None:
        while True:
            before_s = time.monotonic()
            await asyncio.sleep(STEP_S)
            if self.ways.real and before_s > self.told_s + TELLS_S:
                await self.tell(client)
            stands = self.dead or self.paused or self.waits_for_trigger or not self.nodes
            if stands or not self.nodes[0]["released"]:
                continue
            if self.ways.real:
                self.drive_on(time.monotonic() - before_s)
            else:
                self.reach_node()
                await self.tell(client)

    def reach_node(self) -> None:
        self.pass_node(self.nodes.pop(0))
        self.edges.pop(0)
        self.dead = self.ways.dies_at is not None and len(self.passed) > self.ways.dies_at

    def drive_on(self, left_s: float) -> None:
        """Wait at the last node for the rest of its wait, and go on along the edges for the rest of the time."""
        while self.nodes and self.nodes[0]["released"]:
            waited_s = min(left_s, self.waits_s)
            self.waits_s, left_s = self.waits_s - waited_s, left_s - waited_s
            end = self.nodes[0]["nodePosition"]
            away_m = math.dist(self.place, (end["x"], end["y"]))
            speed_m_s = self.edges[0]["maximumSpeed" if self.is_3 else "maxSpeed"] or math.inf
            driven_m = left_s * speed_m_s
            if self.waits_s > 0 or left_s <= 0:
                return
            if driven_m < away_m:
                share = driven_m / away_m
                x, y = self.place
                self.place = (x + share * (end["x"] - x), y + share * (end["y"] - y))
                return
            left_s -= away_m / speed_m_s
            timed = [action for action in self.nodes[0]["actions"] if action["actionType"] != "waitForTrigger"]
            self.reach_node()
            self.waits_s = sum(float(action["actionParameters"][0]["value"]) for action in timed)
            if self.waits_for_trigger:
                return

    async def tell(self, client: Client) -> None:
        if not self.dead:
            self.told_s, state = time.monotonic(), self.state()
            assert (SCHEMAS_3 if self.is_3 else SCHEMAS).errors("state", state) == [], state
            await client.publish(self.topic("state"), json.dumps(state))

    def state(self) -> Json:
        x, y = self.place
        states = [{"actionId": ident, "actionStatus": status} for ident, status in self.actions.items()][-1000:]
        node_keys, edge_keys = ("nodeId", "sequenceId", "released"), ("edgeId", "sequenceId", "released")
        place = {"x": x, "y": y, "theta": 0.0, "mapId": self.ways.map_id}
        of_version: Json = {
            "actionStates": states,
            "agvPosition": {**place, "positionInitialized": True},
            "batteryState": {"batteryCharge": 70.0, "charging": False},
            "safetyState": {"eStop": "NONE", "fieldViolation": False},
        }
        if self.is_3:
            of_version = {
                "actionStates": [each for each in states if ":" in each["actionId"]],
                "instantActionStates": [each for each in states if ":" not in each["actionId"]],
                "mobileRobotPosition": {**place, "localized": True},
                "powerSupply": {"stateOfCharge": 70.0, "charging": False},
                "safetyState": {"activeEmergencyStop": "NONE", "fieldViolation": False},
            }
        return {
            **self.head(),
            "orderId": self.order["orderId"] if self.order else "",
            "orderUpdateId": self.order["orderUpdateId"] if self.order else 0,
            "lastNodeId": self.last["nodeId"],
            "lastNodeSequenceId": self.last["sequenceId"],
            "driving": bool(self.nodes) and not self.paused,
            "paused": self.paused,
            "operatingMode": "AUTOMATIC" if self.ways.automatic else "MANUAL",
            "nodeStates": [{key: node[key] for key in node_keys} for node in self.nodes],
            "edgeStates": [{key: edge[key] for key in edge_keys} for edge in self.edges],
            "errors": self.errors,
            **of_version,
        }


def told_at(agv: Agv, ahead_s: float) -> Json:
    """A state of its with another time."""
    instant = datetime.now(UTC) + timedelta(seconds=ahead_s)
    return {**agv.state(), "timestamp": instant.isoformat(timespec="milliseconds").replace("+00:00", "Z")}


@contextmanager
def broker(folder: Path, *lines: str, port: int | None = None) -> Iterator[int]:
    """Mosquitto on a port of loopback, by default a free one, with more lines in its configuration; gives the port."""
    program = shutil.which("mosquitto", path="/usr/sbin:/usr/bin:/usr/local/sbin:/usr/local/bin")
    assert program is not None, "apt install mosquitto"
    if port is None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
    access = () if any(line.startswith("allow_anonymous") for line in lines) else ("allow_anonymous true",)
    (folder / "mosquitto.conf").write_text(
        "\n".join((f"user {getpass.getuser()}", f"listener {port} 127.0.0.1", *access, *lines, ""))
    )
    with subprocess.Popen([program, "-c", folder / "mosquitto.conf"], stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr is not None
            told = []
            for line in process.stderr:
                told.append(line)
                if "running" in line:
                    break
            else:
                raise AssertionError("".join(told))
            yield port
        finally:
            process.terminate()


@asynccontextmanager
async def driving(port: int, *agvs: Agv) -> AsyncIterator[None]:
    """The vehicles at the broker until the block ends; what goes wrong in them is raised."""
    async with AsyncExitStack() as stack:
        tasks = []
        for agv in agvs:
            will = Will(agv.topic("connection"), json.dumps(agv.connection("CONNECTIONBROKEN")), qos=1, retain=True)
            client = await stack.enter_async_context(Client("127.0.0.1", port, will=will))
            tasks.append(asyncio.create_task(agv.run(client)))
        try:
            yield
        finally:
            outcomes = await asyncio.gather(*map(end_task, tasks), return_exceptions=True)
            for outcome in outcomes:
                if isinstance(outcome, Exception) and not isinstance(outcome, MqttError):
                    raise outcome
