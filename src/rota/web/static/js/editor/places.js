/** Places on the globe as people write them, and as the page writes them. */

const NUMBER = String.raw`[+\-−]?\d+(?:\.\d+)?`;
const ANGLE = String.raw`(${NUMBER})\s*(?:°|º|d|deg\b)?\s*(?:(\d+(?:\.\d+)?)\s*(?:'|′|’|m(?:in)?\b)\s*)?(?:(\d+(?:\.\d+)?)\s*(?:"|″|”|''|′′|s(?:ec)?\b)\s*)?`;
const SIGNED = new RegExp(String.raw`^([NSEW])?\s*${ANGLE}([NSEW])?$`, "i");
const SPACED = /^([NSEW])?\s*(\d+)\s+(\d+(?:\.\d+)?)(?:\s+(\d+(?:\.\d+)?))?\s*([NSEW])?$/i; // 54 21 36 N
const IN_ADDRESS = [/[#&?]map=\d+(?:\.\d+)?\/(-?\d+\.?\d*)\/(-?\d+\.?\d*)/, /@(-?\d+\.?\d*),(-?\d+\.?\d*)/, /^geo:(-?\d+\.?\d*),(-?\d+\.?\d*)/, /[?&](?:q|ll|mlat)=(-?\d+\.?\d*)(?:,|&mlon=)(-?\d+\.?\d*)/];

/**
 * The place that a text names: latitude and longitude in degrees, minutes or seconds, in this order unless letters or
 * sizes tell otherwise, or an address of a map. Null for anything else.
 * @param {string} text
 * @returns {{lat: number, lon: number}|null}
 */
export function placeOf(text) {
  const given = text.trim();
  for (const form of IN_ADDRESS) {
    const found = form.exec(given);
    if (found !== null) {
      return checked(Number(found[1]), Number(found[2]));
    }
  }
  const plain = given.replace(/^\(|\)$|^\[|\]$/g, "").replace(/\b(?:lat|latitude|lon|lng|longitude)\b\s*[:=]?/gi, "");
  for (const [first, second] of halves(plain)) {
    const [one, other] = [angleOf(first), angleOf(second)];
    if (one !== null && other !== null && (one.axis === "" || one.axis !== other.axis)) {
      const turned = one.axis === "lon" || other.axis === "lat" || (one.axis === "" && Math.abs(one.degrees) > 90);
      return turned ? checked(other.degrees, one.degrees) : checked(one.degrees, other.degrees);
    }
  }
  return null;
}

/** The ways to cut a text in two angles: at a semicolon, a comma, behind a letter, at any gap. */
function halves(text) {
  const ways = [];
  for (const mark of [";", ",", "/"]) {
    const parts = text.split(mark);
    if (parts.length === 2) {
      ways.push(parts);
    }
  }
  const commas = text.replace(/(\d),(\d)/g, "$1.$2"); // decimal commas: 54,36; 13,08
  if (commas !== text && text.includes(";")) {
    ways.unshift(commas.split(";"));
  }
  if (commas !== text && /\d,\d+\s+[+-]?\d+,\d/.test(text)) {
    ways.unshift(commas.trim().split(/\s+/));
  }
  const lettered = /^(.*?[NSEW])[\s,;]+(.*[NSEW])$/i.exec(text) ?? /^([NSEW].*?)[\s,;]*([NSEW].*)$/i.exec(text);
  if (lettered !== null) {
    ways.push([lettered[1], lettered[2]]);
  }
  const words = text.trim().split(/\s+/);
  for (let k = 1; k < words.length; k += 1) {
    if (words.length === 2 * k) {
      ways.push([words.slice(0, k).join(" "), words.slice(k).join(" ")]);
    }
  }
  return ways.filter((parts) => parts.length === 2);
}

/** An angle in degrees, and whether it is of latitude or longitude, as far as a letter tells. */
function angleOf(text) {
  const given = text.trim().replaceAll("−", "-");
  const found = SIGNED.exec(given) ?? (/[NSEW]/i.test(given) ? SPACED.exec(given) : null);
  if (found === null) {
    return null;
  }
  const [, before, degrees, minutes = "0", seconds = "0", after] = found;
  if ((before && after) || Number(minutes) >= 60 || Number(seconds) >= 60) {
    return null;
  }
  const letter = (before ?? after ?? "").toUpperCase();
  const size = Math.abs(Number(degrees)) + Number(minutes) / 60 + Number(seconds) / 3600;
  const negative = degrees.startsWith("-") !== (letter === "S" || letter === "W");
  return { degrees: negative ? -size : size, axis: letter === "" ? "" : "NS".includes(letter) ? "lat" : "lon" };
}

function checked(lat, lon) {
  return Math.abs(lat) <= 90 && Math.abs(lon) <= 180 ? { lat, lon } : null;
}

/** A place in degrees: 54.361234° N, 13.081234° E. */
export function placeInWords(lat, lon) {
  const half = (value, positive, negative) => `${Math.abs(value).toFixed(6)}° ${value < 0 ? negative : positive}`;
  return `${half(lat, "N", "S")}, ${half(lon, "E", "W")}`;
}
