"""The figures, one function each: measure and give rows of the table."""

from __future__ import annotations

import statistics
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from benchmarks.anytime import anytime
from benchmarks.bounce_joint_maps import bounce_map
from benchmarks.bounce_teams import bounce_coverage, bounce_monitoring
from benchmarks.charging import charging
from benchmarks.check_legs import check_legs
from benchmarks.city import city
from benchmarks.cold_start import cold_start
from benchmarks.create2_sketch import create2_sketch
from benchmarks.cyclic_visits import cyclic_visits
from benchmarks.damaged_cache import damaged_cache
from benchmarks.export_formats import export_formats
from benchmarks.first_plans import first_plans
from benchmarks.flights import flights
from benchmarks.foreign_agvs import foreign_agvs
from benchmarks.graph_patrols import graph_patrols
from benchmarks.house import house, suite
from benchmarks.kept_phase import kept_phase
from benchmarks.kinds import kinds
from benchmarks.known_plans import known_plans
from benchmarks.large_areas import one_tile, ten_tiles
from benchmarks.lawn_mowing import lawn_mowing
from benchmarks.link_noise import link_noise
from benchmarks.loop_lengths import loop_lengths
from benchmarks.many_robots import many_robots
from benchmarks.methods import cell, compared
from benchmarks.missions import DATA, EXAMPLES, example_missions, write_real_mission
from benchmarks.motion import motion
from benchmarks.never_more import never_more
from benchmarks.one_robot import one_robot
from benchmarks.page_editing import page_editing
from benchmarks.plan_fuzz import mutated_plans
from benchmarks.planning import median_run, met_with, peak, plan_and_check, planned_warm, told
from benchmarks.player import player
from benchmarks.random_flats import bounce_flats
from benchmarks.random_runs import random_missions
from benchmarks.reader_runs import mutated_missions
from benchmarks.rehearsals import rehearsals
from benchmarks.replans import random_losses, replans
from benchmarks.row import Options, Row
from benchmarks.scanned_floors import FLOORS, corners_of, write_floor
from benchmarks.shell import python, rota
from benchmarks.small_jobs import small_jobs
from benchmarks.starts import warm_start
from benchmarks.stopping import stopping
from benchmarks.sun_cases import sun_cases
from benchmarks.sun_deploy import sun_deploy
from benchmarks.sun_frame import sun_frame
from benchmarks.sun_method import sun_method
from benchmarks.swarm_adversarial import swarm_adversarial
from benchmarks.swarm_coverage import swarm_coverage
from benchmarks.swarm_importance import swarm_importance
from benchmarks.swarm_jams import swarm_jams
from benchmarks.swarm_million import swarm_million
from benchmarks.swarm_peer import swarm_peer
from benchmarks.swarm_processes import swarm_processes
from benchmarks.swarm_rest import swarm_rest
from benchmarks.swarm_space import swarm_space
from benchmarks.swarm_step import swarm_step, swarm_threads
from benchmarks.sweeps import plan_on_cluster, sweeps
from benchmarks.warm_cache import measured_warm
from benchmarks.watched_fleet import watched_fleet
from benchmarks.web_load import first_plan, web_load
from rota.files.mission_file import read_mission
from rota.planners.patrol.planner_settings import PatrolSettings

FIG13 = EXAMPLES / "sun2019-fig13.yaml"
FLOOR_PATIENCE_S = 1800.0
BUILDINGS = ("building",)  # walls cut sight there, so nothing general can be asked of the number of robots


def fig13_warm(options: Options) -> Iterator[Row]:
    """Sun 2019's map, planned and checked by a program that has compiled already."""
    runs = planned_warm(FIG13, options.folder)
    reached = median_run(runs).wall_s < 15 and (met_with(runs) or 6) <= 5
    yield Row("sun2019-fig13, plan + check", "< 15 s, at most 5 robots, met", told(runs), reached)


def fig13_cold(options: Options) -> Iterator[Row]:
    """The same in a fresh installation: nothing is compiled yet."""
    with tempfile.TemporaryDirectory() as empty:
        planned = plan_and_check(FIG13, options.folder, {"NUMBA_CACHE_DIR": empty})
    says = "compiling" in planned.plan.err
    reached = planned.wall_s < 60 and says and met_with([planned]) is not None
    measured = f"{told([planned])}; {'says' if says else 'does not say'} that it compiles"
    yield Row("sun2019-fig13, plan + check, first run (cold cache)", "< 60 s, says that it compiles", measured, reached)


def parcel_nl(options: Options) -> Iterator[Row]:
    """A Dutch parcel from GeoJSON."""
    yield _real("parcel-nl", options.folder)


def cumberland(options: Options) -> Iterator[Row]:
    """A building from a ROS map."""
    yield _real("cumberland", options.folder)


def _real(name: str, folder: Path) -> Row:
    what, asked = f"{name}, plan + check", "< 60 s, met"
    if not DATA.is_dir():
        return Row(what, asked, "not measured: ../shared/data is missing", None)
    runs = planned_warm(write_real_mission(name, folder), folder)
    reached = median_run(runs).wall_s < 60 and met_with(runs) is not None
    return Row(what, asked, told(runs), reached)


def scanned_floors(options: Options) -> Iterator[Row]:
    """Floors like scanned buildings, as ragged as those can be."""
    for name in ("office", "ragged-closed", "ragged-entered", "ragged"):
        mission = write_floor(name, FLOORS[name], 0, options.folder)
        found = plan_and_check(mission, options.folder, patience_s=FLOOR_PATIENCE_S)
        floor, corners = FLOORS[name], corners_of(mission)
        closed = "" if floor.close_gaps_m is None else f", gaps under {floor.close_gaps_m:g} m closed"
        closed += ", robots behind its entrances only" if floor.entered else ""
        what = f"{name.split('-')[0]} floor of {floor.columns} x {floor.rows} pixels, {corners} corners{closed}, quick"
        reached = found.met and found.plan.wall_s < 180 and found.peak_bytes < 2e9
        measured = f"{told([found])}; CPU {found.cpu_s:.0f} s"
        yield Row(what, "met, plan in < 180 s, < 2 GB", measured, reached)


def office_floor(options: Options) -> Iterator[Row]:
    """An office floor of 60 rooms from a ROS map, at two efforts."""
    name = "sixty-rooms"
    mission, floor = write_floor(name, FLOORS[name], 0, options.folder), FLOORS[name]
    for effort, most_s in (("quick", 60.0), ("normal", 180.0)):
        found = plan_and_check(mission, options.folder, effort=effort, patience_s=FLOOR_PATIENCE_S)
        what = (
            f"office floor of 60 rooms, {floor.columns} x {floor.rows} pixels, {corners_of(mission)} corners, {effort}"
        )
        reached = found.met and found.plan.wall_s < most_s and found.peak_bytes < 1e9
        yield Row(what, f"met, plan in < {most_s:.0f} s, < 1 GB", f"{told([found])}; CPU {found.cpu_s:.0f} s", reached)


def importing(options: Options) -> Iterator[Row]:
    """How long ``import rota`` keeps one waiting."""
    runs = measured_warm(lambda: python("-c", "import rota"), lambda run: run.wall_s, repeats=5)
    wall_s = statistics.median(run.wall_s for run in runs)
    yield Row("import rota, with the interpreter's start", "< 0.5 s", f"{wall_s:.2f} s, {peak(runs)}", wall_s < 0.5)


def square_kilometre(options: Options) -> Iterator[Row]:
    """The check alone, on a large plan."""
    plan_file = options.folder / "square-kilometre.rota.json"
    made = python("-m", "benchmarks.square_kilometre", plan_file)
    if made.code != 0:
        raise RuntimeError(made.err)
    runs = measured_warm(lambda: rota("check", plan_file), lambda run: run.wall_s)
    wall_s = statistics.median(run.wall_s for run in runs)
    verdict = runs[0].out.splitlines()[0] if runs[0].code in (0, 1) else runs[0].failure()
    reached = wall_s < 10 and all(run.peak_bytes < 2e9 for run in runs) and verdict == "verdict: met"
    measured = f"{wall_s:.1f} s, {peak(runs)}; {verdict}"
    yield Row("check of 20 robots on 1 km2, r = 10 m", "< 10 s, < 2 GB, met", measured, reached)


def examples(options: Options) -> Iterator[Row]:
    """Every example mission."""
    for mission in example_missions():
        other = not isinstance(read_mission(mission).mission.planning, PatrolSettings)  # so many robots as there are
        runs = planned_warm(mission, options.folder, None if other else "quick")
        if other:
            yield Row(f"examples/{mission.name}", "met", told(runs), met_with(runs) is not None)
            continue
        robots = met_with(runs)
        bound = runs[0].report["lower_bound_robots"] if robots else 0
        asked = "met" if mission.stem in BUILDINGS else "met, at most 2 x bound + 1 robots"
        reached = robots is not None and (mission.stem in BUILDINGS or robots <= 2 * bound + 1)
        yield Row(f"examples/{mission.name}", asked, told(runs), reached)


def methods(options: Options) -> Iterator[Row]:
    """Tours, the three traditional methods and the paper's own on Sun 2019's map, compared in one run."""
    for entry in compared(FIG13):
        yield Row(f"sun2019-fig13, method {entry['method']}", "met", cell(entry), entry["met"])


FIGURES: dict[str, Callable[[Options], Iterator[Row]]] = {
    "fig13": fig13_warm,
    "fig13-cold": fig13_cold,
    "cold-start": cold_start,
    "damaged-cache": damaged_cache,
    "parcel-nl": parcel_nl,
    "cumberland": cumberland,
    "scanned-floors": scanned_floors,
    "office-floor": office_floor,
    "city": city,
    "import": importing,
    "warm-start": warm_start,
    "square-kilometre": square_kilometre,
    "examples": examples,
    "methods": methods,
    "formats": export_formats,
    "flights": flights,
    "graph-patrols": graph_patrols,
    "sun-cases": sun_cases,
    "loop-lengths": loop_lengths,
    "sun2019-deploy": sun_deploy,
    "sun2019-frame": sun_frame,
    "sun2019-method": sun_method,
    "swarm-coverage": swarm_coverage,
    "swarm-jams": swarm_jams,
    "swarm-importance": swarm_importance,
    "swarm-rest": swarm_rest,
    "swarm-adversarial": swarm_adversarial,
    "swarm-step": swarm_step,
    "swarm-threads": swarm_threads,
    "swarm-peer": swarm_peer,
    "swarm-million": swarm_million,
    "swarm-space": swarm_space,
    "swarm-processes": swarm_processes,
    "create2-sketch": create2_sketch,
    "bounce-map": bounce_map,
    "bounce-monitoring": bounce_monitoring,
    "bounce-coverage": bounce_coverage,
    "bounce-flats": bounce_flats,
    "one-robot": one_robot,
    "lawn-mowing": lawn_mowing,
    "plan-1-km2": one_tile,
    "plan-10-km2": ten_tiles,
    "many-robots": many_robots,
    "known-plans": known_plans,
    "mutated-missions": mutated_missions,
    "mutated-plans": mutated_plans,
    "check-legs": check_legs,
    "random-missions": random_missions,
    "anytime": anytime,
    "small-jobs": small_jobs,
    "first-plans": first_plans,
    "motion": motion,
    "never-more": never_more,
    "cyclic-visits": cyclic_visits,
    "charging": charging,
    "kinds": kinds,
    "stopping": stopping,
    "house": house,
    "suite": suite,
    "watched-fleet": watched_fleet,
    "web-load": web_load,
    "web-first-plan": first_plan,
    "page-editing": page_editing,
    "player": player,
    "rehearsals": rehearsals,
    "replans": replans,
    "random-losses": random_losses,
    "link-noise": link_noise,
    "kept-phase": kept_phase,
    "foreign-agvs": foreign_agvs,
    "sweep": sweeps,
    "plan-on-cluster": plan_on_cluster,
}
LONG = (
    "motion",
    "never-more",
    "random-missions",
    "anytime",
    "first-plans",
    "lawn-mowing",
    "swarm-million",
    "mutated-plans",
    "scanned-floors",
    "office-floor",
    "city",
    "stopping",
    "foreign-agvs",
    "replans",
    "random-losses",
    "suite",
)  # a quarter of an hour and more: measured only when named, or with --all
