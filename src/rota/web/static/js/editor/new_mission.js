/** A mission that asks for nothing but an area: for a small copter that exists, with a wide camera. */

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
    fleet: {
      robots: "fewest",
      vehicle: "px4",
      speed_m_s: 8,
      sensor: { shape: "disc", radius_m: 25 }, // 80 degrees wide, from 30 m above the ground
      body_radius_m: 0.3,
      altitude_m: 30,
    },
    planner: "patrol",
    patrol: { effort: "quick" },
  };
}
