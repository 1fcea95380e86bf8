/** Fields of a mission in words, as its forms call them: `zones[0].period_s` is the period of zone 1, or of its name. */

/** What the forms call the parts of a document; all others are read by their own names. */
const NAMES = {
  body_radius_m: "body radius",
  cell_m: "cell",
  corner_m: "corners cut by",
  demand: "what is asked",
  leaves_s: "leaves at",
  joins_s: "joins at",
  period_s: "period",
  importance: "importance",
  radius_m: "radius",
  robots: "robots",
  sensor: "sensor",
  side_m: "side",
  speed_m_s: "speed",
  turn_radius_m: "turn radius",
  turn_rate_rad_s: "turn rate",
};
const UNITS = /_(m_s3|m_s2|m_s|rad_s|m2|m|s|deg|wh|w|percent)$/;
const LISTS = { zones: "zone", obstacles: "obstacle", moving_obstacles: "moving obstacle", chargers: "charger" };
const FLEET_LISTS = { robots: "robot", kinds: "kind", entrances: "entrance" };
const IN_TEXT = /\b(?:area|zones|obstacles|moving_obstacles|chargers|fleet|patrol|swarm|bounce|origin)(?:\[\d+\]|\.[a-z][a-z_]*)+/g;

/**
 * A path in words; the document tells names.
 * @param {(string|number)[]} path
 * @param {any} document
 */
export function pathInWords(path, document = null) {
  const [first, second, third, ...rest] = path;
  if (first === "area") {
    return joined("area", detailsOf(path.slice(1)));
  }
  if (first in LISTS && typeof second === "number") {
    return joined(named(LISTS[first], second, document?.[first]?.[second]?.name), detailsOf(path.slice(2)));
  }
  if (first !== "fleet") {
    return path.map(wordOf).join(", ");
  }
  if (second === "start") {
    return third === "points" && typeof rest[0] === "number" ? `start ${rest[0] + 1}` : third === "box" ? "box of starts" : "starts";
  }
  if (second in FLEET_LISTS && typeof third === "number") {
    const name = second === "robots" ? document?.fleet?.robots?.[third]?.name : undefined;
    return joined(named(FLEET_LISTS[second], third, name), detailsOf(rest));
  }
  return joined("fleet", detailsOf(path.slice(1)));
}

/** A text in which fields stand as paths, with words in their place. */
export function textInWords(text, document = null) {
  return text.replace(IN_TEXT, (path) => pathInWords(stepsOf(path), document)).replace(/\b([a-z]+(?:_[a-z]+)*)_(?:m_s3|m_s2|m_s|rad_s|m2|m|s|deg|wh|w|percent)\b/g, (key) => wordOf(key));
}

/** A fault or a warning as a sentence that says where it is. */
export function faultInWords(fault, document = null) {
  if (typeof fault === "string") {
    return textInWords(fault, document);
  }
  const message = textInWords(fault.message ?? String(fault), document);
  if ((fault.path ?? []).length > 0) {
    const place = pathInWords(fault.path, document);
    return `${place.charAt(0).toUpperCase()}${place.slice(1)}: ${message}`;
  }
  return fault.field ? `${textInWords(fault.field, document)}: ${message}` : message;
}

function named(kind, index, name) {
  return typeof name === "string" && name !== "" ? (name.toLowerCase().startsWith(kind) ? name : `${kind} ${name}`) : `${kind} ${index + 1}`;
}

function joined(what, details) {
  return details === "" ? what : `${what}, ${details}`;
}

/** What is inside of a shape, a robot or a fleet. A ring's points are corners. */
function detailsOf(steps) {
  const words = [];
  let corners = false;
  for (const step of steps) {
    if (typeof step !== "number") {
      corners ||= step === "ring" || step === "outer";
      words.push(...(["ring", "outer"].includes(step) ? [] : [wordOf(step)]));
    } else if (corners || words.length === 0) {
      words.push(`corner ${step + 1}`);
      break; // which of the corner's two numbers is told by the message
    } else {
      words.push(String(step + 1));
    }
  }
  return words.join(", ");
}

function wordOf(key) {
  return NAMES[key] ?? String(key).replace(UNITS, "").replaceAll("_", " ");
}

function stepsOf(path) {
  return [...path.matchAll(/\[(\d+)\]|([a-z_]+)/g)].map(([, index, key]) => (index === undefined ? key : Number(index)));
}
