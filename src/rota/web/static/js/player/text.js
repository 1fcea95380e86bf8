/** Numbers and times as people read them. */

/** Seconds with a unit: 4.2 s, 3 min 20 s, 2 h 5 min. */
export function seconds(value) {
  if (value === null || value === Infinity) return "never";
  if (value < 0) return `−${seconds(-value)}`;
  if (value < 99.95) return `${plain(value)} s`;
  if (value < 3599.5) return both(Math.round(value), 60, "min", "s");
  return both(Math.round(value / 60), 60, "h", "min");
}

/** A whole number as so many of a large unit and the rest in a small one. */
function both(whole, each, large, small) {
  const rest = whole % each ? ` ${whole % each} ${small}` : "";
  return `${Math.floor(whole / each)} ${large}${rest}`;
}

/** A clock's reading: 3:05.2, or 1:03:05 from an hour on. */
export function reading(value) {
  const tenths = Math.floor(value * 10 + 1e-6);
  const whole = Math.floor(tenths / 10);
  const two = (number) => String(number).padStart(2, "0");
  const minutes = Math.floor(whole / 60);
  if (minutes < 60) return `${minutes}:${two(whole % 60)}.${tenths % 10}`;
  return `${Math.floor(minutes / 60)}:${two(minutes % 60)}:${two(whole % 60)}`;
}

/** A number with one decimal below 100 and none from there on, without a needless zero. */
export function plain(value) {
  const digits = Math.abs(value) < 0.995 && value !== 0 ? 2 : Math.abs(value) < 99.95 ? 1 : 0;
  return String(Number(value.toFixed(digits)));
}

/** Square metres. */
export function area(value) {
  return value >= 1e5 ? `${plain(value / 1e4)} ha` : `${plain(value)} m²`;
}

/** A share in percent. */
export function percent(share) {
  return `${(100 * share).toFixed(1)} %`;
}

/** A count with its noun. */
export function count(number, one, many = `${one}s`) {
  return `${number} ${number === 1 ? one : many}`;
}
