// @ts-check
// The icons: strokes on a grid of 20 units, drawn for this page.

const SVG = "http://www.w3.org/2000/svg";

/** Path data by name; a leading "#" marks a filled part. */
const ICONS = /** @type {Record<string, string[]>} */ ({
  select: ["M5 3.5v12l3.4-3.1 2.2 4.6 2-.95-2.2-4.55 4.6-.4z"],
  pan: ["M10 2.8v14.4M2.8 10h14.4M8 4.8l2-2 2 2M8 15.2l2 2 2-2M4.8 8l-2 2 2 2M15.2 8l2 2-2 2"],
  polygon: ["M4 7.5 11 3.5l5.5 5-2.5 8-8-1z"],
  rectangle: ["M3.5 5.5h13v9h-13z"],
  circle: ["M10 3.5a6.5 6.5 0 1 0 0 13 6.5 6.5 0 0 0 0-13z"],
  wall: [
    "M3 15.5 8 6l4.5 6L17 4.5", "#M3 14.3a1.2 1.2 0 1 0 0 2.4 1.2 1.2 0 0 0 0-2.4z",
    "#M17 3.3a1.2 1.2 0 1 0 0 2.4 1.2 1.2 0 0 0 0-2.4z",
  ],
  robot: [
    "M6 10.2a3.3 3.3 0 1 0 0 6.6 3.3 3.3 0 0 0 0-6.6z", "M8.6 11 13 6.6",
    "M14.6 3a2.4 2.4 0 1 0 0 4.8 2.4 2.4 0 0 0 0-4.8z", "#M6 12.3a1.2 1.2 0 1 0 0 2.4 1.2 1.2 0 0 0 0-2.4z",
  ],
  measure: ["M3 13.2 13.2 3 17 6.8 6.8 17z", "M6 10.2l1.8 1.8M8.6 7.6l2.6 2.6M11.2 5l1.8 1.8"],
  undo: ["M7.5 4 4 7.5 7.5 11", "M4 7.5h7.5a4.5 4.5 0 0 1 0 9H8"],
  redo: ["M12.5 4 16 7.5 12.5 11", "M16 7.5H8.5a4.5 4.5 0 0 0 0 9H12"],
  open: ["M3 15.5v-11h5l1.8 2H16v2.5", "M3 15.5 5.3 9H18l-2.3 6.5z"],
  save: ["M4 3.5h9.5l3 3v10H4z", "M7 3.5v4h5.5v-4", "M6.5 16.5v-5.5h7.5v5.5"],
  file: ["M5 2.8h6.5L15.5 7v10.2H5z", "M11.5 2.8V7h4"],
  out: ["M10 12.5v-9M6.7 6.6 10 3.3l3.3 3.3", "M4 11v5.5h12V11"],
  help: [
    "M10 3a7 7 0 1 0 0 14 7 7 0 0 0 0-14z", "M8 8a2 2 0 1 1 2.9 1.8c-.6.3-.9.7-.9 1.4v.3",
    "#M10 13.1a.85.85 0 1 0 0 1.7.85.85 0 0 0 0-1.7z",
  ],
  light: [
    "M10 6.8a3.2 3.2 0 1 0 0 6.4 3.2 3.2 0 0 0 0-6.4z",
    "M10 2.5v1.6M10 15.9v1.6M2.5 10h1.6M15.9 10h1.6",
    "M4.7 4.7l1.1 1.1M14.2 14.2l1.1 1.1M15.3 4.7l-1.1 1.1M5.8 14.2l-1.1 1.1",
  ],
  dark: ["M15.8 12.2A6.4 6.4 0 0 1 7.8 4.2a6.4 6.4 0 1 0 8 8z"],
  system: ["M10 3.5a6.5 6.5 0 1 0 0 13 6.5 6.5 0 0 0 0-13z", "#M10 3.5a6.5 6.5 0 0 1 0 13z"],
  play: ["#M6.5 4.2v11.6L15.5 10z"],
  pause: ["#M6 4.5h2.8v11H6zM11.2 4.5H14v11h-2.8z"],
  loop: [
    "M4 9.5V8a2.5 2.5 0 0 1 2.5-2.5H15M12.8 3.2 15.1 5.5l-2.3 2.3",
    "M16 10.5V12a2.5 2.5 0 0 1-2.5 2.5H5M7.2 16.8 4.9 14.5l2.3-2.3",
  ],
  first: ["M5 4.5v11", "#M15 4.8v10.4L7.5 10z"],
  last: ["M15 4.5v11", "#M5 4.8v10.4l7.5-5.2z"],
  previous: ["M12 5l-5 5 5 5"],
  next: ["M8 5l5 5-5 5"],
  down: ["M5.5 8 10 12.5 14.5 8"],
  plus: ["M10 4.5v11M4.5 10h11"],
  minus: ["M4.5 10h11"],
  fit: ["M4 8V4h4M16 8V4h-4M4 12v4h4M16 12v4h-4"],
  close: ["M5.5 5.5l9 9M14.5 5.5l-9 9"],
  check: ["M4.5 10.5 8.3 14.3 15.5 6"],
  warn: ["M10 3.5 17.2 16H2.8z", "M10 8v3.6", "#M10 12.9a.8.8 0 1 0 0 1.6.8.8 0 0 0 0-1.6z"],
  stop: ["#M5.5 5.5h9v9h-9z"],
  grid: ["M3.5 3.5h13v13h-13zM3.5 7.8h13M3.5 12.2h13M7.8 3.5v13M12.2 3.5v13"],
  snap: ["M5 3.5v6a5 5 0 0 0 10 0v-6M5 6.5h3M12 6.5h3M8 3.5v6a2 2 0 0 0 4 0v-6M5 3.5h3M12 3.5h3"],
  eye: ["M2.5 10S5.2 5 10 5s7.5 5 7.5 5-2.7 5-7.5 5-7.5-5-7.5-5z", "M10 7.7a2.3 2.3 0 1 0 0 4.6 2.3 2.3 0 0 0 0-4.6z"],
  trash: ["M4 5.8h12M8 5.5V3.5h4v2M5.5 5.8l.7 10.7h7.6l.7-10.7M8.5 9v4.5M11.5 9v4.5"],
  duplicate: ["M7 7h9v9H7z", "M4 13V4h9"],
  dice: [
    "M4 4h12v12H4z",
    "#M7 6a1 1 0 1 0 0 2 1 1 0 0 0 0-2zM13 12a1 1 0 1 0 0 2 1 1 0 0 0 0-2zM10 9a1 1 0 1 0 0 2 1 1 0 0 0 0-2z",
  ],
  image: ["M3.5 4.5h13v11h-13z", "M3.5 13l4-4 3.5 3.5 2-2 3.5 3.5"],
  sparkle: ["M9 3.5l1.5 4.5L15 9.5 10.5 11 9 15.5 7.5 11 3 9.5 7.5 8z", "M15.2 13.2v3.6M13.4 15h3.6"],
  brand: [
    "M4 15 8.6 7.4 16 4.6", "#M4 13.2a1.8 1.8 0 1 0 0 3.6 1.8 1.8 0 0 0 0-3.6z",
    "M16.2 2.9a1.7 1.7 0 1 0 0 3.4 1.7 1.7 0 0 0 0-3.4z",
  ],
});

/**
 * Draw an icon in the colour of the text around it.
 * @param {string} name
 * @param {number} [size] pixels
 * @returns {SVGElement}
 */
export function icon(name, size = 18) {
  const svg = document.createElementNS(SVG, "svg");
  const given = { viewBox: "0 0 20 20", width: size, height: size, class: "icon", "aria-hidden": true,
    focusable: false };
  for (const [key, value] of Object.entries(given)) svg.setAttribute(key, String(value));
  for (const data of ICONS[name] ?? []) {
    const filled = data.startsWith("#");
    const path = document.createElementNS(SVG, "path");
    path.setAttribute("d", filled ? data.slice(1) : data);
    path.setAttribute("class", filled ? "fill" : "stroke");
    svg.append(path);
  }
  return svg;
}
