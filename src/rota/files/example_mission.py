"""The commented mission that ``rota new`` writes."""

from __future__ import annotations

_TEXT = """\
# A mission for Rota. Plan it with:   rota plan THIS_FILE
# Lengths are metres, times seconds, speeds metres per second.
rota: 1                              # version of this format
name: my-mission

# metres: x east, y north.  wgs84: longitude first, then latitude, in degrees.
coordinates: metres
# origin: {lat: 48.1, lon: 11.5}     # places a mission in metres on the globe, for exports that need it

# Where robots may be and must look. One of:
#   a ring of points, as here (the last point need not repeat the first)
#   {outer: [[x, y], ...], holes: [[[x, y], ...], ...]}
#   {geojson: parcel.geojson, feature: NAME}      without feature: all polygons of the file
#   {map: depot.yaml, inside: [3.0, 4.0]}         a ROS map: the free part that holds this point
#   {text: ..., cell_m: 0.5}                      a small map, typed as lines of . (free) and # (obstacle)
# Paths of files start at the folder of this file.
area: [[0, 0], [80, 0], [80, 60], [50, 60], [50, 40], [0, 40]]

# Neither entered nor seen through. A ring, or {ring | circle | geojson: ...} with blocks: motion (a no-fly zone,
# which one can look into) or blocks: sight (a hedge). The ground under blocks: motion is to be seen like any other,
# from outside; asks: nothing beside it leaves it out.
obstacles:
  - [[20, 12], [32, 12], [32, 20], [20, 20]]
  - {circle: {centre: [60, 25], radius_m: 3}, blocks: motion}

# Every point of the area must be seen at least once in any window of this length; null asks nothing.
period_s: 60

# Parts with a period of their own; where zones overlap the smallest period rules.
zones:
  - {name: gate, period_s: 20, ring: [[65, 45], [80, 45], [80, 60], [65, 60]]}
  - {name: tank, period_s: 30, circle: {centre: [8, 8], radius_m: 6}}
  # importance: 5 tells a swarm what a square metre of a zone is worth, period_s or not; see below
  # demand: visit asks that a robot comes into the zone, rather than that each of its points is seen
  # - {geojson: zones.geojson}       # one zone per feature, with the properties name and period_s

# For planner: swarm only: what a square metre outside zones with an importance is worth. 0: only zones matter.
# importance: 1                      # or a map: {map: crowds.png, black: 0, white: 10}, spread over the area

fleet:
  robots: fewest                     # or a number, or a list: [{name: left}, {name: right, speed_m_s: 3}]
  vehicle: arducopter-tuned          # or arducopter (by default parameters), arducopter-targets, px4, dji,
                                     # arduplane, agv, turtlebot4, none: presets what is not given. Without one robots
                                     # change speed at once
  speed_m_s: 8
  sensor: {shape: disc, radius_m: 8}     # or {shape: square, side_m: 16}
  body_radius_m: 0                   # how far robots keep from walls and from each other
  turn_rate_rad_s: null              # null: turning takes no time
  turn_radius_m: 0                   # wings and fast multirotors: turns are arcs of this radius or more
  # acceleration_m_s2: 2.5           # along the way; corner_acceleration_m_s2 round corners, jerk_m_s3 of its changes
  # corner_m: 2                      # how far corners may be cut; 0: robots stop there
  # climb_m_s, descend_m_s, top_airspeed_m_s, wind_m_s
  altitude_m: 15                     # for exports
  start: null                        # {box: [[0, 0], [5, 5]]} or {points: [[1, 1], [2, 1]]}; null: anywhere
  # entrances: [[2, 2]]              # robots are only where they can come to from there; without it anywhere, and on
                                     # a ROS map where they can come to from inside; null: anywhere there, too
  rally_points: []                   # [[2, 2]]: where copters may land instead of at home, when they return by
                                     # themselves

# What nobody can see from anywhere a robot can stand: exclude it and say so, or refuse the mission.
unseeable: exclude
holds_within_s: null                 # all robots are in their loops, from when on periods hold, so soon; null: any time

planner: patrol                      # or swarm (robots spread and hold), bounce (a bump sensor and a clock)
patrol:
  effort: normal                     # quick | normal | high
  method: tours                      # or one to compare with: parallel, sequential, decomposition, sun2019
  # sun2019: {frame: {alpha_m: 10000}}   # stages of that method and their settings, see docs/methods.md
  period_margin: 0                   # reserve against wind: 0.05 plans with periods shorter by 5 %
  range_margin_m: 0                  # reserve against poor localisation: plans with sensors that reach so much less far
"""


def example_mission_text() -> str:
    """A valid mission file in YAML with a comment on every key."""
    return _TEXT
