/** Going to a place on the globe: typed or pasted into a field, or pasted anywhere on the page. */

import { el } from "../dom.js";
import { placeOf } from "./places.js";

/**
 * @param {HTMLElement} box over the map, so that it takes no room from the tools
 * @param {(place: {lat: number, lon: number}) => void} go
 */
export function startGoing(box, go) {
  const input = el("input", { type: "text", id: "go-to", size: "20", autocomplete: "off", placeholder: "54.36, 13.08", "aria-describedby": "go-to-fault" });
  const fault = el("span", { class: "fault", id: "go-to-fault", role: "alert" });
  const tell = (text) => {
    fault.textContent = text;
    input.setAttribute("aria-invalid", String(text !== ""));
  };
  const tryIt = () => {
    const place = placeOf(input.value);
    tell(place === null && input.value.trim() !== "" ? "Latitude, longitude: 54.36, 13.08 or 54°21'36\"N 13°4'48\"E" : "");
    if (place !== null) {
      go(place);
    }
  };
  input.addEventListener("keydown", (event) => event.key === "Enter" && tryIt());
  input.addEventListener("input", () => tell(""));
  input.addEventListener("paste", () => window.setTimeout(tryIt));
  document.addEventListener("paste", (event) => {
    const typing = event.target instanceof Element && event.target.closest("input, textarea, select, dialog") !== null;
    const text = event.clipboardData?.getData("text") ?? "";
    const place = typing || document.body.dataset.tab !== "edit" ? null : placeOf(text);
    if (place !== null) {
      input.value = text.trim();
      go(place);
    }
  });
  box.append(fault, el("label", { for: "go-to" }, "Go to"), input);
}
