/**
 * Longitude and latitude (WGS84) to local metres and back: azimuthal equidistant about an origin, as rota.files.geodesy
 * has it. Distances and azimuths are Vincenty's (Survey Review 23:88, 1975), good to a tenth of a millimetre.
 *
 * @typedef {{lat: number, lon: number}} Origin
 */

const MAJOR_M = 6378137;
const FLATTENING = 1 / 298.257223563;
const MINOR_M = MAJOR_M * (1 - FLATTENING);
const DEGREE = Math.PI / 180;
const ROUNDS = 100;
const SMALL = 1e-13;

/**
 * Local metres of a place: x east, y north. NaN for places opposite to the origin, where the formula has no answer.
 * @param {Origin} origin
 * @param {number} lon degrees
 * @param {number} lat degrees
 * @returns {[number, number]}
 */
export function toMetres(origin, lon, lat) {
  const difference = (lon - origin.lon) * DEGREE;
  const [sinFrom, cosFrom] = reduced(origin.lat);
  const [sinTo, cosTo] = reduced(lat);
  let lambda = difference;
  for (let round = 0; round < ROUNDS; round += 1) {
    const [sinLambda, cosLambda] = [Math.sin(lambda), Math.cos(lambda)];
    const east = cosTo * sinLambda;
    const north = cosFrom * sinTo - sinFrom * cosTo * cosLambda;
    const sinSigma = Math.hypot(east, north);
    if (sinSigma === 0) {
      return [0, 0];
    }
    const cosSigma = sinFrom * sinTo + cosFrom * cosTo * cosLambda;
    const sigma = Math.atan2(sinSigma, cosSigma);
    const sinAlpha = (cosFrom * cosTo * sinLambda) / sinSigma;
    const cos2Alpha = 1 - sinAlpha * sinAlpha;
    const cosMiddle = cos2Alpha > 0 ? cosSigma - (2 * sinFrom * sinTo) / cos2Alpha : 0;
    const next = difference + longitudeTerm(sinAlpha, cos2Alpha, sigma, sinSigma, cosSigma, cosMiddle);
    if (Math.abs(next - lambda) < SMALL) {
      const [A, B] = series(cos2Alpha);
      const distance = MINOR_M * A * (sigma - sigmaTerm(B, sinSigma, cosSigma, cosMiddle));
      return [(distance * east) / sinSigma, (distance * north) / sinSigma];
    }
    lambda = next;
  }
  return [NaN, NaN];
}

/**
 * Longitude and latitude in degrees of local metres.
 * @param {Origin} origin
 * @param {number} x
 * @param {number} y
 * @returns {[number, number]} longitude, latitude
 */
export function toDegrees(origin, x, y) {
  const distance = Math.hypot(x, y);
  if (distance === 0) {
    return [origin.lon, origin.lat];
  }
  const [sinAzimuth, cosAzimuth] = [x / distance, y / distance];
  const [sinFrom, cosFrom] = reduced(origin.lat);
  const sigmaFrom = Math.atan2(sinFrom, cosFrom * cosAzimuth);
  const sinAlpha = cosFrom * sinAzimuth;
  const cos2Alpha = 1 - sinAlpha * sinAlpha;
  const [A, B] = series(cos2Alpha);
  let sigma = distance / (MINOR_M * A);
  let cosMiddle = 0;
  for (let round = 0; round < ROUNDS; round += 1) {
    cosMiddle = Math.cos(2 * sigmaFrom + sigma);
    const next = distance / (MINOR_M * A) + sigmaTerm(B, Math.sin(sigma), Math.cos(sigma), cosMiddle);
    const settled = Math.abs(next - sigma) < SMALL;
    sigma = next;
    if (settled) {
      break;
    }
  }
  const [sinSigma, cosSigma] = [Math.sin(sigma), Math.cos(sigma)];
  cosMiddle = Math.cos(2 * sigmaFrom + sigma);
  const across = sinFrom * sinSigma - cosFrom * cosSigma * cosAzimuth;
  const lat = Math.atan2(
    sinFrom * cosSigma + cosFrom * sinSigma * cosAzimuth,
    (1 - FLATTENING) * Math.hypot(sinAlpha, across),
  );
  const lambda = Math.atan2(sinSigma * sinAzimuth, cosFrom * cosSigma - sinFrom * sinSigma * cosAzimuth);
  const difference = lambda - longitudeTerm(sinAlpha, cos2Alpha, sigma, sinSigma, cosSigma, cosMiddle);
  return [origin.lon + difference / DEGREE, lat / DEGREE];
}

/** The origin of shapes within bounds in degrees: their centre to 1e-7 degrees, as the reader of missions takes it. */
export function originOf(west, south, east, north) {
  return { lon: round7((west + east) / 2), lat: round7((south + north) / 2) };
}

/** Seven decimals: about a centimetre. */
export function round7(degrees) {
  return Math.round(degrees * 1e7) / 1e7;
}

/** Sine and cosine of the reduced latitude. */
function reduced(lat) {
  const tangent = (1 - FLATTENING) * Math.tan(lat * DEGREE);
  const cosine = 1 / Math.sqrt(1 + tangent * tangent);
  return [tangent * cosine, cosine];
}

/** Vincenty's A and B (equations 3 and 4). */
function series(cos2Alpha) {
  const u2 = (cos2Alpha * (MAJOR_M * MAJOR_M - MINOR_M * MINOR_M)) / (MINOR_M * MINOR_M);
  const A = 1 + (u2 / 16384) * (4096 + u2 * (-768 + u2 * (320 - 175 * u2)));
  const B = (u2 / 1024) * (256 + u2 * (-128 + u2 * (74 - 47 * u2)));
  return [A, B];
}

/** Vincenty's difference of sigma (equation 6). */
function sigmaTerm(B, sinSigma, cosSigma, cosMiddle) {
  const twice = 2 * cosMiddle * cosMiddle - 1;
  const last = (B / 6) * cosMiddle * (4 * sinSigma * sinSigma - 3) * (4 * cosMiddle * cosMiddle - 3);
  return B * sinSigma * (cosMiddle + (B / 4) * (cosSigma * twice - last));
}

/** What the ellipsoid adds to a difference of longitude (equations 10 and 11). */
function longitudeTerm(sinAlpha, cos2Alpha, sigma, sinSigma, cosSigma, cosMiddle) {
  const C = (FLATTENING / 16) * cos2Alpha * (4 + FLATTENING * (4 - 3 * cos2Alpha));
  const twice = 2 * cosMiddle * cosMiddle - 1;
  return (1 - C) * FLATTENING * sinAlpha * (sigma + C * sinSigma * (cosMiddle + C * cosSigma * twice));
}
