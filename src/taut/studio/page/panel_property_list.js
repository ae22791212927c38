// @ts-check
// Which properties the selection has, as data: what each field shows, and the scene that a new value makes. Pure.

import { renamed, setField } from "studio/edits.js";
import { insertVertex, removeVertex, setVertex } from "studio/edits_outline.js";
import { boxOf, called, isRing, obstacleNamed, robotNamed, shapeOf, verticesOf } from "studio/scene.js";

/**
 * @typedef {import("studio/scene.js").Scene} Scene
 * @typedef {import("studio/scene.js").Ref} Ref
 * @typedef {import("studio/panel_fields.js").FieldSpec} FieldSpec
 * @typedef {{spec: FieldSpec, get: (scene: Scene) => any, mixed?: (scene: Scene) => boolean,
 *   set: (scene: Scene, value: any) => Scene, label: (scene: Scene, value: any) => string,
 *   select?: (value: any) => Ref[]}} Property
 * @typedef {{title: string, properties: Property[]}} Group
 * @typedef {{ref: Ref, count: number, ring: boolean, fewest: number}} Corners
 */

const DEGREE = Math.PI / 180;
const AT_GOAL = [{ value: "stay", label: "stays there" }, { value: "leave", label: "leaves" }];
const KIND_WORDS = { polygon: "Polygon", rectangle: "Rectangle", circle: "Circle", line: "Wall" };

/**
 * Selected ends of robots stand for their robots, corners for what they belong to; each thing once.
 * @param {readonly Ref[]} selection
 * @returns {Ref[]}
 */
export function things(selection) {
  /** @type {Map<string, Ref>} */
  const found = new Map();
  for (const { kind, name } of selection) {
    const whole = kind === "start" || kind === "goal" ? "robot" : kind;
    found.set(`${whole} ${name}`, name === undefined ? { kind: whole } : { kind: whole, name });
  }
  return [...found.values()];
}

/**
 * What makes the panel another one: with the same signature only the values differ.
 * @param {Scene} scene
 * @param {readonly Ref[]} selection
 */
export function signatureOf(scene, selection) {
  const of = (/** @type {Ref} */ ref) => {
    const obstacle = ref.kind === "obstacle" ? obstacleNamed(scene, ref.name) : undefined;
    const corners = ref.kind === "obstacle" || ref.kind === "workspace" ? verticesOf(scene, ref).length : 0;
    return [ref.kind, ref.name, obstacle && shapeOf(obstacle), corners];
  };
  return JSON.stringify([Boolean(scene.bounds), things(selection).map(of)]);
}

/**
 * @param {Scene} scene
 * @param {readonly Ref[]} selection
 * @returns {{title: string, groups: Group[], corners: Corners | null}}
 */
export function propertiesOf(scene, selection) {
  const refs = things(selection);
  if (refs.length === 0) return { title: "Scene", groups: sceneGroups(scene), corners: null };
  if (refs.length > 1) return { title: `${refs.length} objects`, groups: commonGroups(scene, refs), corners: null };
  const [ref] = refs;
  if (ref.kind === "workspace") {
    return { title: "Workspace", groups: boundsGroups(scene), corners: scene.bounds ? null : cornersOf(scene, ref) };
  }
  if (ref.kind === "robot") return { title: "Robot", groups: robotGroups(ref), corners: null };
  const obstacle = obstacleNamed(scene, ref.name);
  if (!obstacle) return { title: "Scene", groups: sceneGroups(scene), corners: null };
  const shape = shapeOf(obstacle);
  const corners = shape === "polygon" || shape === "line" ? cornersOf(scene, ref) : null;
  return { title: KIND_WORDS[shape], groups: obstacleGroups(ref, shape), corners };
}

/**
 * The two fields of a corner.
 * @param {Ref} ref with its vertex
 * @returns {Property[]}
 */
export function cornerProperties(ref) {
  const at = (/** @type {Scene} */ scene) => verticesOf(scene, ref)[ref.vertex ?? 0];
  return ["x", "y"].map((axis, k) => ({
    spec: metres(axis, `${axis} of corner ${(ref.vertex ?? 0) + 1}`, { hideLabel: true, unit: "m" }),
    get: (scene) => at(scene)?.[k],
    set: (scene, value) => setVertex(scene, ref, k === 0 ? [value, at(scene)[1]] : [at(scene)[0], value]),
    label: (scene) => `move ${called(scene, [ref])}`,
  }));
}

/** @param {Scene} scene @param {Ref} ref a corner */
export const withoutCorner = (scene, ref) => removeVertex(scene, ref);

/**
 * A new corner in the middle of the edge after this one.
 * @param {Scene} scene
 * @param {Ref} ref a corner
 */
export function withCorner(scene, ref) {
  const all = verticesOf(scene, ref);
  const k = ref.vertex ?? 0;
  const [[x, y], [nextX, nextY]] = [all[k], all[(k + 1) % all.length]];
  return insertVertex(scene, { kind: ref.kind, name: ref.name }, k, [(x + nextX) / 2, (y + nextY) / 2]);
}

/** @param {Scene} scene @param {Ref} ref @returns {Corners} */
function cornersOf(scene, ref) {
  const ring = isRing(scene, ref);
  return { ref, count: verticesOf(scene, ref).length, ring, fewest: ring ? 3 : 2 };
}

/** @param {Scene} scene @returns {Group[]} */
function sceneGroups(scene) {
  const ref = /** @type {Ref} */ ({ kind: "scene" });
  return [
    { title: "", properties: [field(ref, { name: "name", label: "Name", type: "text", placeholder: "untitled" },
      (now) => now.name ?? "")] },
    ...boundsGroups(scene),
    { title: "Rules", properties: [
      field(ref, metres("clearance", "Clearance", { min: 0, help: "kept free between robots and obstacles or walls" }),
        (now) => now.clearance),
      field(ref, metres("gap", "Gap", { min: 0, help: "kept free between robots" }), (now) => now.gap),
      field(ref, { name: "headway", label: "Headway", type: "number", unit: "s", min: 0, step: 0.1,
        help: "the gap also holds this much earlier and later" }, (now) => now.headway),
      field(ref, { name: "at_goal", label: "At its goal a robot", type: "select", options: AT_GOAL },
        (now) => now.at_goal),
    ] },
  ];
}

/** @param {Scene} scene @returns {Group[]} */
function boundsGroups({ bounds }) {
  if (!bounds) return [];
  const names = ["Left", "Bottom", "Right", "Top"];
  return [{ title: "Bounds", properties: [0, 1, 2, 3].map((k) => ({
    spec: metres(`bounds-${k}`, names[k]),
    get: (scene) => scene.bounds?.[k],
    set: (scene, value) => setField(scene, { kind: "scene" }, "bounds",
      scene.bounds?.map((before, j) => (j === k ? value : before))),
    label: () => `set ${names[k].toLowerCase()} of the bounds`,
  })) }];
}

/** @param {Ref} ref @param {string} shape @returns {Group[]} */
function obstacleGroups(ref, shape) {
  const of = (/** @type {Scene} */ scene) => /** @type {any} */ (obstacleNamed(scene, ref.name));
  const position = (/** @type {Scene} */ scene, /** @type {number} */ axis) => {
    const { circle, rectangle } = of(scene);
    return (circle ?? rectangle ?? boxOf({ ...of(scene), width: 0 }))[axis];
  };
  const place = [
    field(ref, metres("x", "x"), (scene) => position(scene, 0)),
    field(ref, metres("y", "y"), (scene) => position(scene, 1)),
  ];
  const size = {
    rectangle: [
      field(ref, metres("width", "Width", { above: 0 }), (scene) => of(scene).rectangle[2]),
      field(ref, metres("height", "Height", { above: 0 }), (scene) => of(scene).rectangle[3]),
      angle(ref, (scene) => of(scene).angle ?? 0),
    ],
    circle: [field(ref, metres("radius", "Radius", { above: 0 }), (scene) => of(scene).radius)],
    line: [field(ref, metres("width", "Width", { above: 0 }), (scene) => of(scene).width)],
    polygon: [],
  }[shape] ?? [];
  return [{ title: "", properties: [nameField(ref)] }, { title: shape === "circle" ? "Centre" : "Position",
    properties: place }, ...(size.length ? [{ title: "Size", properties: size }] : [])];
}

/** @param {Ref} ref @returns {Group[]} */
function robotGroups(ref) {
  const of = (/** @type {Scene} */ scene) => /** @type {any} */ (robotNamed(scene, ref.name));
  const ends = ["start", "goal"].map((end) => ({
    title: end === "start" ? "Start" : "Goal",
    properties: ["x", "y"].map((axis, k) => field({ kind: /** @type {any} */ (end), name: ref.name },
      metres(axis, axis), (scene) => of(scene)[end][k])),
  }));
  return [{ title: "", properties: [nameField(ref)] }, ...ends,
    { title: "Body", properties: robotFields().map((spec) => field(ref, spec, (now) => of(now)[spec.name] ?? null)) }];
}

/** @returns {FieldSpec[]} */
function robotFields() {
  return [
    metres("radius", "Radius", { min: 0 }),
    { name: "speed", label: "Speed", type: "number", unit: "m/s", above: 0, step: 0.1 },
    metres("clearance", "Clearance", { min: 0, optional: true, placeholder: "the scene's" }),
    { name: "start_time", label: "Starts at", type: "number", unit: "s", min: 0, step: 1, optional: true,
      placeholder: "0" },
    { name: "at_goal", label: "At its goal", type: "select",
      options: [{ value: null, label: "as the scene says" }, ...AT_GOAL] },
  ];
}

/**
 * Fields that all of several things have; where they differ the field is empty and says so.
 * @param {Scene} scene
 * @param {Ref[]} refs
 * @returns {Group[]}
 */
function commonGroups(scene, refs) {
  const robots = refs.every(({ kind }) => kind === "robot");
  if (robots) {
    return [{ title: "All of them", properties: robotFields().map((spec) => common(refs, spec,
      (now, ref) => /** @type {any} */ (robotNamed(now, ref.name))?.[spec.name] ?? null)) }];
  }
  const shapes = new Set(refs.map((ref) => {
    const obstacle = ref.kind === "obstacle" ? obstacleNamed(scene, ref.name) : undefined;
    return obstacle ? shapeOf(obstacle) : "other";
  }));
  const [shape] = shapes;
  if (shapes.size > 1) return [];
  const of = (/** @type {Scene} */ now, /** @type {Ref} */ ref) => /** @type {any} */ (obstacleNamed(now, ref.name));
  /** @type {Record<string, Property[]>} */
  const fields = {
    circle: [common(refs, metres("radius", "Radius", { above: 0 }), (now, ref) => of(now, ref)?.radius)],
    line: [common(refs, metres("width", "Width", { above: 0 }), (now, ref) => of(now, ref)?.width)],
    rectangle: [
      common(refs, metres("width", "Width", { above: 0 }), (now, ref) => of(now, ref)?.rectangle[2]),
      common(refs, metres("height", "Height", { above: 0 }), (now, ref) => of(now, ref)?.rectangle[3]),
    ],
  };
  return fields[shape] ? [{ title: "All of them", properties: fields[shape] }] : [];
}

/** @param {string} name @param {string} label @param {Partial<FieldSpec>} [more] @returns {FieldSpec} */
const metres = (name, label, more = {}) => ({ name, label, type: "number", unit: "m", step: 0.1, ...more });

/** @param {Ref} ref @param {FieldSpec} spec @param {(scene: Scene) => any} get @returns {Property} */
function field(ref, spec, get) {
  return {
    spec,
    get,
    set: (scene, value) => setField(scene, ref, spec.name, value),
    label: (scene) => `set ${spec.name.replace("_", " ")} of ${called(scene, [ref])}`,
  };
}

/** @param {Ref} ref @param {(scene: Scene) => number} get @returns {Property} */
function angle(ref, get) {
  const made = field(ref, { name: "angle", label: "Angle", type: "number", unit: "deg", step: 15, digits: 12 },
    (scene) => get(scene) / DEGREE);
  return { ...made, set: (scene, value) => setField(scene, ref, "angle", value * DEGREE) };
}

/** @param {Ref} ref @returns {Property} */
function nameField(ref) {
  return {
    spec: { name: "name", label: "Name", type: "text" },
    get: () => ref.name,
    set: (scene, value) => renamed(scene, ref, value),
    label: (_, value) => `rename ${ref.name} to ${value}`,
    select: (value) => [{ kind: ref.kind, name: value }],
  };
}

/**
 * @param {Ref[]} refs @param {FieldSpec} spec @param {(scene: Scene, ref: Ref) => any} get
 * @returns {Property}
 */
function common(refs, spec, get) {
  const mixed = (/** @type {Scene} */ scene) => refs.some((ref) => get(scene, ref) !== get(scene, refs[0]));
  return {
    spec,
    mixed,
    get: (scene) => (mixed(scene) ? undefined : get(scene, refs[0])),
    set: (scene, value) => refs.reduce((now, ref) => setField(now, ref, spec.name, value), scene),
    label: () => `set ${spec.name.replace("_", " ")} of ${refs.length} objects`,
  };
}
