/** The colours of what is drawn on the map, in light and dark. */

import { ROUTES, ROUTES_DARK } from "./colours.js";

const LIGHT = {
  ground: "#fdfdfb", ink: "#1b1f24", halo: "#ffffff", obstacle: "#4a4a4a", noEntry: "#b3261e", noSight: "#2e7d32",
  zone: "#4a2f00", footprint: "rgb(255 255 255 / 0.28)", covered: "rgb(0 158 115 / 0.35)", coveredEdge: "#00664b",
  away: "#8a8a8a", danger: "#c4002f", bump: "#c4002f", routes: ROUTES,
};
const DARK = {
  ground: "#23282e", ink: "#f1f3f5", halo: "#14171a", obstacle: "#8b9098", noEntry: "#ff8a80", noSight: "#81c784",
  zone: "#ffd479", footprint: "rgb(255 255 255 / 0.18)", covered: "rgb(44 199 154 / 0.38)", coveredEdge: "#6fe3c3",
  away: "#8a8f96", danger: "#ff5c7a", bump: "#ff8fa3", routes: ROUTES_DARK,
};

/** Whether the page is dark: by its switch, or else as the system says. */
export function isDark() {
  const chosen = document.body.dataset.theme ?? document.documentElement.dataset.theme;
  if (chosen === "dark" || chosen === "light") return chosen === "dark";
  return window.matchMedia("(prefers-color-scheme: dark)").matches;
}

/** The colours for now. */
export function colours() {
  return isDark() ? DARK : LIGHT;
}

/** Calls back when the page turns dark or light. Returns what ends that. */
export function onThemeChange(act) {
  const media = window.matchMedia("(prefers-color-scheme: dark)");
  media.addEventListener("change", act);
  const watcher = new MutationObserver(act);
  for (const node of [document.body, document.documentElement]) {
    watcher.observe(node, { attributes: true, attributeFilter: ["data-theme"] });
  }
  return () => {
    media.removeEventListener("change", act);
    watcher.disconnect();
  };
}
