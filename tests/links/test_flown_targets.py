"""A round that ArduCopter's simulator flew by timed targets, beside the way that was predicted.

`flown_targets.csv` has where the fourth of five copters over the harbour (examples/harbour-copters.yaml with sensors
that reach 24 m and vehicle arducopter-targets) said it was in its second round: ArduCopter 4.6-dev, its simulated
quadcopter, no wind, WPNAV_ACCEL 500, PSC_JERK_XY 20, GUID_TIMEOUT 0.5. `flown_targets_way.csv` has its planned points,
each with the acceleration along the leg after it. The clock of all went as the plan's.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rota.links.rounded_track import RoundedTrack
from rota.model.plan import Trajectory

HERE = Path(__file__).parent
FAST_M_S = 2.0  # a copter that is slower is at many moments of its way within what positions err by


def test_a_flown_round_is_where_and_when_it_was_predicted() -> None:
    way = np.loadtxt(HERE / "flown_targets_way.csv", delimiter=",", skiprows=1)
    flown = np.loadtxt(HERE / "flown_targets.csv", delimiter=",", skiprows=1)[::4]
    trajectory = Trajectory(
        robot="robot-5", times_s=way[:, 0], positions_m=way[:, 1:3], accelerations_m_s2=way[:-1, 3] * (1 - 1e-6)
    )
    track = RoundedTrack(trajectory, 3.0 / 1.69, 1.5)
    moments = [track.at(float(time_s)) for time_s in flown[:, 0]]
    off_m = np.hypot(*(np.array([moment.place_m for moment in moments]) - flown[:, 1:]).T)
    fast = np.array([np.hypot(*moment.velocity_m_s) > FAST_M_S for moment in moments])
    found_s = [
        time_s - track.nearest_s(flown[k, 1:], time_s - 2, time_s + 2, 0.02)
        for k, time_s in enumerate(flown[:, 0].tolist())
    ]
    late_s = np.abs(np.array(found_s))[fast]
    assert np.percentile(off_m, 95) < 0.3
    assert off_m.max() < 1.0
    assert np.percentile(late_s, 95) < 0.1
    assert fast.mean() > 0.8
