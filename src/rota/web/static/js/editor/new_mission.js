/** A mission that asks for nothing but an area: its numbers suit a small quadcopter. */

/** @returns {import("./store.js").MissionDocument} */
export function newMission(name) {
  return {
    rota: 1,
    name,
    coordinates: "metres",
    area: [],
    obstacles: [],
    period_s: 120,
    zones: [],
    fleet: { robots: "fewest", speed_m_s: 5, sensor: { shape: "disc", radius_m: 15 }, body_radius_m: 0.3, altitude_m: 30 },
    planner: "patrol",
    patrol: { effort: "quick" },
  };
}
