// @ts-check
// Sums of numbers as people write them: 4.6 + 0.1 is 4.7, so that moving things to and fro leaves no dust in files.

const MOST_DECIMALS = 15;

/**
 * Decimals that a number is written with; more than 15 mean that it was computed, not typed.
 * @param {number} number
 */
function decimals(number) {
  const text = String(number);
  const mark = text.indexOf("e");
  const exponent = mark < 0 ? 0 : Number(text.slice(mark + 1));
  const digits = mark < 0 ? text : text.slice(0, mark);
  const point = digits.indexOf(".");
  return Math.max(0, (point < 0 ? 0 : digits.length - point - 1) - exponent);
}

/**
 * The sum as done on paper where both numbers have few decimals, else that of doubles.
 * @param {number} a
 * @param {number} b
 */
export function sum(a, b) {
  const exact = a + b;
  if (Number.isInteger(a) && Number.isInteger(b)) return exact;
  const places = Math.max(decimals(a), decimals(b));
  if (places > MOST_DECIMALS) return exact;
  const written = Number(exact.toFixed(places));
  // Far from zero the decimals of one number are below the last bit of the other: keep what doubles say.
  return Math.abs(written - exact) <= 4 * Number.EPSILON * Math.max(Math.abs(a), Math.abs(b)) ? written : exact;
}

/**
 * @param {number} a
 * @param {number} b
 */
export function difference(a, b) {
  return sum(a, -b);
}

/**
 * A point moved.
 * @param {readonly number[]} point
 * @param {number} dx
 * @param {number} dy
 * @returns {[number, number]}
 */
export function shifted(point, dx, dy) {
  return [sum(point[0], dx), sum(point[1], dy)];
}

/**
 * A point turned about a centre; quarter turns are exact.
 * @param {readonly number[]} point
 * @param {readonly number[]} centre
 * @param {number} angle radians, counter-clockwise
 * @returns {[number, number]}
 */
export function turned(point, centre, angle) {
  const [cos, sin] = direction(angle);
  const [x, y] = [difference(point[0], centre[0]), difference(point[1], centre[1])];
  return shifted(centre, cos * x - sin * y, sin * x + cos * y);
}

/**
 * Cosine and sine, exact at quarter turns.
 * @param {number} angle
 * @returns {[number, number]}
 */
export function direction(angle) {
  const quarters = angle / (Math.PI / 2);
  const whole = Math.round(quarters);
  if (Math.abs(quarters - whole) > 4 * Number.EPSILON * Math.max(1, Math.abs(whole))) {
    return [Math.cos(angle), Math.sin(angle)];
  }
  const turn = ((whole % 4) + 4) % 4;
  return [[1, 0, -1, 0][turn], [0, 1, 0, -1][turn]];
}

/**
 * An angle in (−π, π].
 * @param {number} angle
 */
export function wrapped(angle) {
  if (angle > -Math.PI && angle <= Math.PI) return angle;
  const rest = angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
  return rest <= -Math.PI ? Math.PI : rest;
}
