// @ts-check
// Numbers as people type them: sums, units and a comma where a point is meant.

/** What one of a unit is in the base unit of its kind. */
const UNITS = /** @type {Record<string, Record<string, number>>} */ ({
  m: { m: 1, cm: 0.01, mm: 0.001, km: 1000 },
  s: { s: 1, ms: 0.001, min: 60 },
  "m/s": { "m/s": 1, "km/h": 1 / 3.6, "cm/s": 0.01 },
  deg: { "°": 1, deg: 1, rad: 180 / Math.PI },
  "": {},
});

const PLAIN = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;

/**
 * Read a number of a kind ("m", "s", "m/s", "deg" or ""): "3.5", "3 + 0.5", "50 cm", "(16 - 2) / 3", "2 * 40 cm".
 * @param {string} text
 * @param {string} [unit]
 * @returns {{value: number} | {wrong: string}}
 */
export function readNumber(text, unit = "") {
  // 1,5 is 1.5 in much of the world; a comma never separates anything in these fields.
  const plain = text.trim().replaceAll("−", "-").replaceAll("·", "*").replaceAll("×", "*").replaceAll(",", ".");
  try {
    const value = parse(split(plain, UNITS[unit] ?? {}));
    if (!Number.isFinite(value)) return { wrong: "That is not a finite number." };
    // A number alone is taken as typed; of what was reckoned the last digit is noise: 0.1 + 0.05 is 0.15.
    return { value: PLAIN.test(plain) ? value : Number(value.toPrecision(15)) };
  } catch (error) {
    return { wrong: /** @type {Error} */ (error).message };
  }
}

/**
 * Write a number so that it reads back as the same: the shortest form, without noise such as 0.30000000000000004
 * where `digits` are given.
 * @param {number} value
 * @param {number} [digits] significant ones
 */
export function writeNumber(value, digits) {
  const text = String(digits === undefined ? value : Number(value.toPrecision(digits)));
  return text.replace("-", "−");
}

/**
 * @param {string} text
 * @param {Record<string, number>} units
 * @returns {(string | number)[]}
 */
function split(text, units) {
  let rest = text;
  if (rest === "") throw new Error("Type a number.");
  /** @type {(string | number)[]} */
  const parts = [];
  const names = Object.keys(units).sort((a, b) => b.length - a.length);
  while (rest) {
    const digits = /^(\d+\.?\d*|\.\d+)(e[+-]?\d+)?/i.exec(rest);
    const name = typeof parts.at(-1) === "number" && names.find((each) => rest.startsWith(each));
    if (digits) parts.push(Number(digits[0]));
    else if (name) parts.push(/** @type {number} */ (parts.pop()) * units[name]);
    else if ("+-*/()".includes(rest[0])) parts.push(rest[0]);
    else throw new Error(`“${rest.slice(0, 12)}” is no part of a number${told(names)}.`);
    rest = rest.slice(digits ? digits[0].length : name ? name.length : 1).trimStart();
  }
  return parts;
}

/** @param {string[]} names */
const told = (names) => (names.length ? ` (units: ${[...names].reverse().join(", ")})` : "");

/** @param {(string | number)[]} parts @returns {number} */
function parse(parts) {
  let k = 0;
  const sum = /** @returns {number} */ () => {
    let value = product();
    while (parts[k] === "+" || parts[k] === "-") value += parts[k++] === "+" ? product() : -product();
    return value;
  };
  const product = /** @returns {number} */ () => {
    let value = factor();
    while (parts[k] === "*" || parts[k] === "/") value = parts[k++] === "*" ? value * factor() : value / factor();
    return value;
  };
  const factor = /** @returns {number} */ () => {
    const part = parts[k++];
    if (part === "-") return -factor();
    if (part === "+") return factor();
    if (typeof part === "number") return part;
    if (part !== "(") throw new Error("A number is missing.");
    const value = sum();
    if (parts[k++] !== ")") throw new Error("A bracket is not closed.");
    return value;
  };
  const value = sum();
  if (k < parts.length) throw new Error("Two numbers stand side by side; write +, −, * or / between them.");
  return value;
}
