"""Real processes on loopback: they start, one dies by SIGKILL, the rest go on, all end, and a plan is left."""

from __future__ import annotations

import multiprocessing
import os
import signal
import socket
import threading
import time
from dataclasses import replace

import pytest
from tests.planners.swarm.nodes.air import S, mission_of
from tests.planners.swarm.nodes.test_hearing import malformed

from rota.check import check_plan
from rota.errors import LinkError, MissionError
from rota.planners.swarm.nodes.launch import last_change_s, run_swarm
from rota.planners.swarm.nodes.node import RobotNode
from rota.planners.swarm.nodes.process import run_robot, scene_for
from rota.planners.swarm.nodes.recording import Recorder
from rota.planners.swarm.nodes.scene import scene_of
from rota.planners.swarm.nodes.telling import LEFT, MEMBER, WAITING, Telling, write_telling
from rota.planners.swarm.nodes.udp import UdpPort, addresses_of, clock_of
from rota.planning.robot_processes import Launch, ProcessSettings, is_loopback


def free_ports(count: int) -> int:
    """The first of so many ports in a row that nobody has, by trying."""
    for first in range(20_000 + os.getpid() % 10_000, 60_000, count):
        taken = []
        try:
            for port in range(first, first + count):
                taken.append(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
                taken[-1].bind(("127.0.0.1", port))
        except OSError:
            continue
        finally:
            for one in taken:
                one.close()
        return first
    raise AssertionError("no free ports")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="starting anew takes seconds for each process")
def test_processes_go_on_when_one_is_killed_and_all_end() -> None:
    mission = mission_of(5, 40, (15, 25), sensor_m=9, speed_m_s=10)
    settings = ProcessSettings(seed=1, port=free_ports(6))
    ids: dict[int, int] = {}
    noise = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    rows = []

    def measured(time_s: float, share: float, robots: int) -> None:
        rows.append((time_s, share, robots))
        for datagram in malformed(50):
            noise.sendto(datagram, ("127.0.0.1", settings.port))
        if len(rows) == 2:
            os.kill(ids[2], signal.SIGKILL)

    launch = Launch(time_limit_s=3.2, started=ids.update, measured=measured)
    record = run_swarm(scene_for(mission, settings), settings, launch)
    noise.close()
    assert not multiprocessing.active_children()
    assert [robot.end for robot in record.robots] == ["runs", "runs", "silent", "runs", "runs"]
    assert (rows[1][2], rows[-1][2]) == (5, 4)  # on a busy machine not all five are heard before the first row
    assert rows[1][1] > 1.3 * rows[0][1]
    assert 40 <= record.robots[0].dropped <= 200
    assert sum(robot.dropped for robot in record.robots[1:]) == 0
    for robot in record.robots:
        assert robot.ticks > (8 if robot.end == "silent" else 25)
    (died,) = (robot for robot in record.plan.mission.fleet.robots or () if robot.leaves_s is not None)
    assert died.name == "robot-3"
    assert 0.9 < died.leaves_s < 2.0
    report = check_plan(record.plan)
    assert report.verdict == "met", report.violations


@pytest.mark.skipif(not hasattr(os, "fork"), reason="starting anew takes seconds for each process")
def test_a_launch_that_may_run_for_long_ends_when_all_rest() -> None:
    mission = mission_of(2, 40, (15, 25), sensor_m=9, speed_m_s=10)
    settings = ProcessSettings(seed=1, port=free_ports(3))
    began_s = time.monotonic()
    record = run_swarm(scene_for(mission, settings), settings, Launch(time_limit_s=3600, ends_at_rest=True))
    assert time.monotonic() - began_s < 600
    assert record.plan.run_end is not None
    assert record.plan.run_end.at_rest
    assert [robot.end for robot in record.robots] == ["runs", "runs"]


def test_rest_is_looked_for_when_the_last_has_joined_or_left() -> None:
    mission = mission_of(3, 40, (15, 25), sensor_m=9, speed_m_s=10)
    robots = mission.fleet.robots or ()
    changing = (replace(robots[0], leaves_s=90.0), replace(robots[1], joins_s=40.0), robots[2])
    mission = replace(mission, fleet=replace(mission.fleet, robots=changing))
    assert last_change_s(mission, range(3)) == 90
    assert last_change_s(mission, (1, 2)) == 40
    assert last_change_s(mission, (2,)) == 0


def test_nothing_is_recorded_of_what_was_after_the_limit() -> None:
    scene = scene_for(mission_of(2, 40, (15, 25), sensor_m=9, speed_m_s=10), ProcessSettings())
    second_ns, nodes = 10**9, [RobotNode(scene, robot, began_ns=0, begin_ns=0) for robot in range(2)]
    recorder = Recorder(scene, 0, until_ns=2 * second_ns)
    told = [node.tick(now_ns, ()) for now_ns in range(0, 5 * second_ns, scene.period_ns) for node in nodes]
    recorder.hear([datagram for datagram in told if datagram is not None], 5 * second_ns)  # all of it late
    record = recorder.record(2 * second_ns, stopped=True)
    assert [row[0] for row in record.coverage] == [0, 1, 2]
    assert max(float(way.times_s[-1]) for way in record.plan) <= 2 + 2 * scene.period_ns * 1e-9
    assert [robot.end for robot in record.robots] == ["runs", "runs"]


def test_a_robot_by_itself_listens_tells_and_leaves_when_asked() -> None:
    mission = mission_of(2, 40, (15, 25), sensor_m=9, speed_m_s=10, time_step_s=0.02)
    settings = ProcessSettings(port=free_ports(3))
    scene = scene_for(mission, settings)
    ear = UdpPort(addresses_of(settings, 2)[2], ())
    asked = threading.Event()
    robot = threading.Thread(target=run_robot, args=(scene, 0, settings), kwargs={"should_stop": asked.is_set})
    robot.start()
    clock = clock_of(addresses_of(settings, 2))
    recorder, life = Recorder(scene, clock()), None
    until = time.monotonic() + 60
    while (life is None or life.left_s is None) and time.monotonic() < until:
        recorder.hear(ear.receive(), clock())
        life = recorder._lives.get(0)
        if life is not None and life.joined_s is not None and not asked.is_set():
            with pytest.raises(LinkError, match=r"cannot listen there .* is this robot running already"):
                run_robot(scene, 0, settings)
            asked.set()
        time.sleep(0.002)
    robot.join(60)
    ear.close()
    assert life is not None
    assert (life.first.state, life.last.state) == (WAITING, LEFT)
    assert not robot.is_alive()


def test_addresses_and_the_clock_follow_from_the_hosts() -> None:
    assert addresses_of(ProcessSettings(port=50_000), 2) == tuple(("127.0.0.1", 50_000 + k) for k in range(3))
    far = ProcessSettings(hosts=("10.0.0.1", "10.0.0.2", "10.0.0.9"))
    assert addresses_of(far, 2)[2] == ("10.0.0.9", 47602)
    assert clock_of(addresses_of(far, 2)) is time.time_ns
    assert clock_of(addresses_of(ProcessSettings(), 2)) is time.monotonic_ns
    assert [is_loopback(host) for host in ("127.0.0.3", "localhost", "::1", "10.0.0.1", "example.org")] == [
        True, True, True, False, False,
    ]  # fmt: skip
    with pytest.raises(MissionError, match="hosts: 2 is not allowed; give one, or one for each of the 4 robots"):
        addresses_of(ProcessSettings(hosts=("a", "b")), 4)
    with pytest.raises(MissionError, match="port: 65533 is not allowed: 4 robots and a recorder need ports"):
        addresses_of(ProcessSettings(port=65533), 4)
    with pytest.raises(MissionError, match="port: 0 is not allowed"):
        ProcessSettings(port=0)


# ------------------------------------------------------------ what a recorder makes of hand-made tellings


def telling(robot: int, tick: int, time_s: float, x: float, vx: float = 0.0, state: int = MEMBER) -> Telling:
    told_ns = round((10 + time_s) * S)
    return Telling(state, robot, tick, 0, 500, told_ns, S // 10, x, 20.0, 30.0, vx, 0.0, 0.5, 9.0, 10.0)


def recorded(*tellings: Telling, end_s: float) -> tuple[Recorder, int]:
    scene = scene_of(mission_of(3, 40, (5, 35), sensor_m=9, speed_m_s=10))
    recorder, end_ns = Recorder(scene, 10 * S), round((10 + end_s) * S)
    for one in sorted(tellings, key=lambda one: one.told_ns):
        recorder.hear([write_telling(one, scene.number)], one.told_ns)
    recorder.hear([], end_ns)
    return recorder, end_ns


def test_a_record_is_the_way_that_was_told_and_what_was_lost_is_crossed_straight() -> None:
    recorder, end_ns = recorded(
        telling(0, 0, 0.0, 5.0, 10.0),
        telling(0, 1, 0.1, 6.0, 10.0),
        telling(0, 3, 0.3, 9.0, 5.0),  # the one between was lost
        telling(0, 4, 0.45, 9.5),
        telling(1, 0, 0.05, 25.0),
        telling(1, 4, 0.45, 25.0),
        end_s=0.5,
    )
    record = recorder.record(end_ns, stopped=True)
    assert [t.robot for t in record.plan] == ["robot-1", "robot-2"]
    moved, stood = record.plan.trajectories
    assert moved.times_s == pytest.approx([0, 0.1, 0.2, 0.3, 0.4], abs=1e-6)
    assert moved.positions_m[:, 0] == pytest.approx([5, 6, 7, 9, 9.5])
    assert stood.times_s.tolist() == [0.0]
    assert [robot.lost for robot in record.robots] == [1, 3]
    assert record.plan.run_end is not None
    assert record.plan.run_end.reason == "stopped"
    assert "4 tellings were lost" in record.warnings[1]
    assert "robot-3 was never heard" in record.warnings[0]
    assert record.coverage[0][2] == 2


def test_the_silent_have_left_and_a_second_life_is_not_in_the_plan() -> None:
    again = telling(0, 0, 1.4, 5.0, state=WAITING)
    steady = [telling(1, k, 0.1 * k, 25.0) for k in range(16)]
    recorder, end_ns = recorded(telling(0, 0, 0.0, 5.0, 10.0), telling(0, 1, 0.1, 6.0, 10.0), again, *steady, end_s=1.6)
    record = recorder.record(end_ns, stopped=False)
    first = record.plan.mission.fleet.robot("robot-1")
    assert first.leaves_s == pytest.approx(0.2)
    assert record.plan.mission.fleet.robot("robot-2").leaves_s is None
    assert record.plan.trajectories[0].positions_m[-1].tolist() == pytest.approx([7.0, 20.0])
    assert any("robot-1 came back" in warning for warning in record.warnings)
    assert [count for _, _, count in record.coverage] == [2, 1]


@pytest.mark.parametrize(("places_m", "wants"), [((10.0, 30.0), False), ((2.0, 4.0), True)])
def test_processes_rest_by_the_rule_of_the_simulation(places_m: tuple[float, float], wants: bool) -> None:
    """Two discs of 9 m that overlap at a wall want to go on; where both stand all the same, they are blocked."""
    news_s = 0.1 * scene_of(mission_of(3, 40, (5, 35), sensor_m=9, speed_m_s=10)).grid.place_graph.news_steps
    for seconds, at_rest in ((1.5, False), (2.5, not wants), (news_s + 2.5, True)):
        standing = [telling(k, t, 0.1 * t, places_m[k]) for t in range(round(10 * seconds)) for k in range(2)]
        recorder, end_ns = recorded(*standing, end_s=seconds)
        assert recorder.is_at_rest(end_ns) == at_rest
    end = recorder.record(end_ns, stopped=False).plan.run_end
    assert end is not None
    assert (end.reason, end.blocked) == (("blocked", ("robot-1", "robot-2")) if wants else ("rest", ()))


def test_short_steps_are_no_rest() -> None:
    slow = scene_of(mission_of(1, 40, (5, 35), sensor_m=9, speed_m_s=1e-3))
    recorder = Recorder(slow, 0)
    for t in range(40):
        one = telling(0, t, 0.1 * t - 10, 20.0 + 5e-6 * t, 5e-5)  # half the speed of this one
        recorder.hear([write_telling(one, slow.number)], one.told_ns)
    assert recorder.quiet_s(4 * S) == 0


def test_a_plan_over_hills_has_heights() -> None:
    mission = mission_of(2, 40, (5, 35), sensor_m=9, speed_m_s=10)
    scene = scene_of(mission, ground_m=lambda x, y: 0.5 * x + y)
    recorder = Recorder(scene, 10 * S)
    recorder.hear([write_telling(telling(0, 0, 0.0, 5.0, 4.0), scene.number)], 10 * S)
    (way,) = recorder.record(11 * S, stopped=False).plan.trajectories
    altitude = mission.fleet.altitude_m
    assert way.positions_m.ravel() == pytest.approx([5.0, 20.0, 22.5 + altitude, 5.4, 20.0, 22.7 + altitude])


def test_nothing_heard_is_nothing_recorded() -> None:
    recorder, end_ns = recorded(end_s=1)
    with pytest.raises(LinkError, match="no robot was heard"):
        recorder.record(end_ns, stopped=True)


def test_other_planners_have_no_processes() -> None:
    from rota.model.mission import DiscSensor, Fleet
    from rota.planners.patrol.planner_settings import PatrolSettings
    from rota.planning.planner import planner_of

    mission = mission_of(2, 40, (5, 35), sensor_m=9, speed_m_s=10)
    fleet = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=5))
    patrol = replace(mission, fleet=fleet, period_s=100.0, planning=PatrolSettings())
    with pytest.raises(MissionError, match="planner: patrol is not allowed"):
        planner_of(patrol).robot_processes(patrol, ProcessSettings())
