/** Values inside a document by their path: reading, and changing without touching the value before. */

/** @typedef {(string|number)[]} Path */

/** The value at a path; undefined where there is none. */
export function valueAt(document, path) {
  return path.reduce((value, step) => (value === null || value === undefined ? undefined : value[step]), document);
}

/** A copy with another value at a path; undefined takes the key away. Objects on the way are made where none are. */
export function withValue(document, path, value) {
  if (path.length === 0) {
    return value;
  }
  const [step, ...rest] = path;
  const before = document ?? (typeof step === "number" ? [] : {});
  const inner = withValue(before[step], rest, value);
  if (inner === before[step]) {
    return document ?? before;
  }
  const copy = Array.isArray(before) ? [...before] : { ...before };
  if (inner !== undefined) {
    copy[step] = inner;
  } else if (Array.isArray(copy)) {
    copy.splice(Number(step), 1);
  } else {
    delete copy[step];
  }
  return copy;
}

/** Whether a path begins with another. */
export function startsWith(path, start) {
  return start.length <= path.length && start.every((step, k) => String(step) === String(path[k]));
}

/** Paths as one word, for attributes. */
export function pathKey(path) {
  return path.join("/");
}
