/** A mission that asks for nothing but an area: its numbers suit a small quadcopter. */

/**
 * @param {string} name
 * @param {boolean} onGlobe whether it is drawn on map tiles
 * @returns {import("./store.js").MissionDocument}
 */
export function newMission(name, onGlobe) {
  return {
    rota: 1,
    name,
    coordinates: onGlobe ? "wgs84" : "metres",
    area: [],
    obstacles: [],
    period_s: 120,
    zones: [],
    fleet: { robots: "fewest", speed_m_s: 5, sensor: { shape: "disc", radius_m: 15 }, body_radius_m: 0.3, altitude_m: 30 },
    planner: "patrol",
    patrol: { effort: "quick" },
  };
}
