// @ts-check
// The picture under the scene, a floor plan say: read from a file, put to scale, painted.

/** @typedef {import("./scene.js").Point} Point */
/**
 * @typedef {{name: string, data: string, pixels: readonly [number, number], x: number, y: number, scale: number,
 *   opacity: number, locked: boolean}} Underlay data: the picture as a data: URL; x, y: its lower left corner, metres;
 *   scale: metres a pixel
 */

/** Sides of a picture in pixels: larger ones are made smaller, so that the browser can keep them with the draft. */
const MOST_PIXELS = 2048;
/** Of the canvas in which a picture is made smaller. */
const FORMAT = "image/webp";
const QUALITY = 0.9;

/** @type {Map<string, HTMLImageElement>} pictures that can be painted, by their data */
const decoded = new Map();

/**
 * Read a picture and lay it over a box.
 * @param {Blob & {name?: string}} file
 * @param {readonly number[]} box xmin, ymin, xmax, ymax in metres
 * @returns {Promise<Underlay>} fails with a sentence where the file is no picture
 */
export async function underlayFromFile(file, box) {
  const name = file.name ?? "picture";
  const image = await imageFrom(await dataOf(file), name);
  const data = smaller(image);
  await imageFrom(data, name);
  const { width, height } = fitted(image);
  const [xmin, ymin, xmax, ymax] = box;
  const scale = Number(Math.min((xmax - xmin) / width, (ymax - ymin) / height).toPrecision(6));
  const x = (xmin + xmax - width * scale) / 2;
  const y = (ymin + ymax - height * scale) / 2;
  return { name, data, pixels: [width, height], x, y, scale, opacity: 0.5, locked: false };
}

/**
 * Make a picture that comes from a draft ready to be painted.
 * @param {Underlay} underlay
 */
export async function prepareUnderlay(underlay) {
  await imageFrom(underlay.data, underlay.name);
}

/**
 * Scale a picture so that two points of it are so many metres apart; the first stays where it is.
 * @param {Underlay} underlay
 * @param {Point} a
 * @param {Point} b
 * @param {number} metres
 * @returns {Underlay}
 */
export function calibrated(underlay, a, b, metres) {
  const factor = metres / Math.hypot(b[0] - a[0], b[1] - a[1]);
  return {
    ...underlay,
    x: a[0] + (underlay.x - a[0]) * factor,
    y: a[1] + (underlay.y - a[1]) * factor,
    scale: underlay.scale * factor,
  };
}

/**
 * @param {Underlay} underlay
 * @param {number} dx
 * @param {number} dy
 * @returns {Underlay}
 */
export function movedUnderlay(underlay, dx, dy) {
  return { ...underlay, x: underlay.x + dx, y: underlay.y + dy };
}

/**
 * Layer: the picture, first of all.
 * @type {import("./board.js").Layer}
 */
export function paintUnderlay(context, view) {
  /** @type {Underlay | null} */
  const underlay = view.state.underlay;
  const image = underlay && decoded.get(underlay.data);
  if (!underlay || !image) return;
  const [width, height] = underlay.pixels;
  const left = view.x(underlay.x);
  const top = view.y(underlay.y + height * underlay.scale);
  const perPixel = underlay.scale * view.camera.scale;
  context.globalAlpha = underlay.opacity;
  context.imageSmoothingQuality = "high";
  context.drawImage(image, left, top, width * perPixel, height * perPixel);
}

/**
 * @param {Blob} file
 * @returns {Promise<string>}
 */
function dataOf(file) {
  return new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve(String(reader.result));
    reader.onerror = () => reject(new Error(`${reader.error?.message ?? "The file"} cannot be read.`));
    reader.readAsDataURL(file);
  });
}

/**
 * @param {string} data
 * @param {string} name
 * @returns {Promise<HTMLImageElement>}
 */
async function imageFrom(data, name) {
  const known = decoded.get(data);
  if (known) return known;
  const image = new Image();
  image.src = data;
  try {
    await image.decode();
  } catch {
    throw new Error(`${name} is no picture that this browser can show.`);
  }
  decoded.set(data, image);
  return image;
}

/**
 * The size of a picture once it is small enough; a drawing without a size of its own gets one.
 * @param {HTMLImageElement} image
 */
function fitted({ naturalWidth, naturalHeight }) {
  const [wide, high] = naturalWidth && naturalHeight ? [naturalWidth, naturalHeight] : [MOST_PIXELS, MOST_PIXELS];
  const factor = Math.min(1, MOST_PIXELS / Math.max(wide, high));
  return { width: Math.max(1, Math.round(wide * factor)), height: Math.max(1, Math.round(high * factor)) };
}

/** @param {HTMLImageElement} image */
function smaller(image) {
  const canvas = document.createElement("canvas");
  const { width, height } = fitted(image);
  [canvas.width, canvas.height] = [width, height];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  context.imageSmoothingQuality = "high";
  context.drawImage(image, 0, 0, width, height);
  return canvas.toDataURL(FORMAT, QUALITY);
}
