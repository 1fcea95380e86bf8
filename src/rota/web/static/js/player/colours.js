/** Colours that survive colour blindness: viridis for shares of the period, red with stripes beyond it. */

const VIRIDIS = [
  [68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141],
  [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37],
];
export const LEVELS = 256;
export const LATE = [228, 0, 58];
export const STRIPE = [255, 255, 255];
export const NEVER = [255, 185, 201];
export const NOT_YET = [128, 128, 128];
export const EXCLUDED = [128, 128, 128];

/** Okabe-Ito without yellow; dark and light in turn. On a dark ground black becomes a light grey. */
export const ROUTES = ["#0072B2", "#E69F00", "#882255", "#009E73", "#000000", "#56B4E9", "#D55E00", "#CC79A7"];
export const ROUTES_DARK = ["#4FA3E0", "#E69F00", "#D07BA5", "#2CC79A", "#C9C9C9", "#8CD0F5", "#F28A4B", "#F0A8CF"];

/** A colour of an image's pixel, as a little-endian 32-bit number. */
export function pixel([red, green, blue], alpha = 255) {
  return ((alpha << 24) | (blue << 16) | (green << 8) | red) >>> 0;
}

/** A colour of viridis at a share 0..1. */
export function viridis(share) {
  const at = Math.min(Math.max(share, 0), 1) * (VIRIDIS.length - 1);
  const low = Math.min(Math.floor(at), VIRIDIS.length - 2);
  return VIRIDIS[low].map((value, k) => Math.round(value + (at - low) * (VIRIDIS[low + 1][k] - value)));
}

/** The lookup table of viridis: `LEVELS` pixels. */
export function table() {
  return Uint32Array.from({ length: LEVELS }, (_, k) => pixel(viridis(k / (LEVELS - 1))));
}

/** A colour as CSS has it. */
export function css([red, green, blue]) {
  return `rgb(${red} ${green} ${blue})`;
}
