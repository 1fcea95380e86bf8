/** Dark and light: as the system has it until the switch is used, then as it was left. */

import { byId } from "./dom.js";

const KEY = "rota-theme";
const system = window.matchMedia("(prefers-color-scheme: dark)");

function kept() {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null; // storage may be forbidden
  }
}

function show(theme) {
  document.body.dataset.theme = theme;
  const name = theme === "dark" ? "Light colours" : "Dark colours";
  const toggle = byId("theme");
  toggle.setAttribute("aria-label", name);
  toggle.title = name;
  document.dispatchEvent(new CustomEvent("rota-theme", { detail: theme }));
}

/** Starts the switch. */
export function startTheme() {
  const now = () => kept() ?? (system.matches ? "dark" : "light");
  show(now());
  system.addEventListener("change", () => show(now()));
  byId("theme").addEventListener("click", () => {
    const next = now() === "dark" ? "light" : "dark";
    try {
      localStorage.setItem(KEY, next);
    } catch {
      // then it lasts until the page is left
    }
    show(next);
  });
}
