"""The document of the studio's page: edits are pure, undo gives back what was byte for byte, snapping finds the place.

The modules of the page are called in the page itself, in Chromium.
"""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import pytest

from taut import Rectangle

if TYPE_CHECKING:
    from collections.abc import Iterator

    from playwright.sync_api import Browser, Page

    from studio_page import RunningStudio

pytest_plugins = ("studio_page",)

STUDIO_WORDS = ("thesis-2",)

MODULES = ("scene", "scene_hits", "edits", "edits_numbers", "edits_outline", "history", "snapping", "store")

SCENE: dict[str, Any] = {
    "taut": 1,
    "name": "yard",
    "bounds": [0, 0, 16, 12],
    "clearance": 0.1,
    "gap": 0.05,
    "headway": 0,
    "at_goal": "stay",
    "obstacles": [
        {"name": "O1", "polygon": [[6, 6], [8, 7], [6.5, 9]]},
        {"name": "table", "rectangle": [2, 3, 2, 1]},
        {"name": "pillar", "circle": [12, 4.6], "radius": 0.5},
        {"name": "wall-09", "line": [[10, 8], [12, 8], [12, 10]], "width": 0.2},
    ],
    "robots": [
        {"name": "R1", "start": [1, 1], "goal": [14, 10], "radius": 0.25, "speed": 1.5},
        {"name": "R2", "start": [1, 10], "goal": [14, 2], "radius": 0.2, "speed": 1, "clearance": 0.3},
    ],
}


@pytest.fixture(scope="module")
def sheet(browser: Browser, studio: RunningStudio) -> Iterator[Page]:
    """Return one page for all tests here: they call its modules and change nothing on it."""
    context = browser.new_context()
    opened = context.new_page()
    opened.goto(studio.url)
    yield opened
    context.close()


def run(sheet: Page, body: str, **given: Any) -> Any:
    """Run statements in the page that may use its modules and `given`, and return what they return."""
    imports = "".join(f'const {name} = await import("studio/{name}.js");\n' for name in MODULES)
    return sheet.evaluate(f"async (given) => {{ {imports} {HELPERS} {body} }}", {"scene": SCENE, **given})


HELPERS = """
const yard = scene.deepFreeze(given.scene);
const obstacle = (name, vertex) => ({ kind: "obstacle", name, ...(vertex === undefined ? {} : { vertex }) });
const robot = (name) => ({ kind: "robot", name });
const made = (state = yard) => {
  const file = { name: "yard.yaml", dirty: false };
  const own = store.createStore({ scene: state, revision: 0, selection: [], file });
  return [own, history.createHistory(own)];
};
const wrong = (edit) => {
  try { edit(); return null; } catch (error) {
    if (!(error instanceof edits.EditError)) throw error;
    return error.message;
  }
};
const throwing = (seed) => () => {
  seed = (seed * 1664525 + 1013904223) % 2 ** 32;
  return seed / 2 ** 32;
};
"""

EDITING = """
const random = throwing(given.seed);
const pick = (list) => list[Math.floor(random() * list.length)];
const number = () => Number((random() * 40 - 12).toFixed(Math.floor(random() * 17)));
const point = () => [number(), number()];
const refsOf = (s) => [
  ...s.obstacles.map(({ name }) => obstacle(name)),
  ...s.robots.flatMap(({ name }) => ["robot", "start", "goal"].map((kind) => ({ kind, name }))),
  { kind: "workspace" },
];
const some = (s) => [pick(refsOf(s)), pick(refsOf(s)), pick(refsOf(s))];
const corner = (s) => ({ ...pick(refsOf(s)), vertex: Math.floor(random() * 4) });
const FIELDS = ["x", "y", "radius", "width", "height", "angle", "speed", "clearance", "gap", "headway", "start_time"];
const KINDS = {
  polygon: (s) => edits.addObstacle(s, { polygon: [point(), point(), point(), point()] }),
  rectangle: (s) => edits.addObstacle(s, { rectangle: [...point(), random() + 0.1, 2], angle: random() - 0.5 }),
  circle: (s) => edits.addObstacle(s, { circle: point(), radius: random() + 0.01 }),
  wall: (s) => edits.addObstacle(s, { line: [point(), point(), point()], width: 0.1 }),
  robot: (s) => edits.addRobot(s, { start: point(), goal: point() }),
  remove: (s) => edits.removed(s, [pick(refsOf(s))]),
  duplicate: (s) => edits.duplicated(s, [pick(refsOf(s)), pick(refsOf(s))], 0.5, -0.5).scene,
  move: (s) => edits.moved(s, some(s), number(), number()),
  rotate: (s) => edits.rotated(s, some(s), pick([Math.PI / 2, -Math.PI, 0.3, number()])),
  corner: (s) => edits_outline.setVertex(s, corner(s), point()),
  insert: (s) => edits_outline.insertVertex(s, pick(refsOf(s)), Math.floor(random() * 4), point()),
  takeCorner: (s) => edits_outline.removeVertex(s, corner(s)),
  side: (s) => edits_outline.edgeMoved(s, pick(refsOf(s)), Math.floor(random() * 4), number(), number()),
  handle: (s) => edits_outline.resized(s, pick(refsOf(s)), Math.floor(random() * 8), point()),
  field: (s) => edits.setField(s, pick([...refsOf(s), { kind: "scene" }]), pick(FIELDS), Math.abs(number())),
  atGoal: (s) => edits.setField(s, pick(refsOf(s)), "at_goal", pick(["stay", "leave", null])),
  name: (s) => edits.renamed(s, pick(refsOf(s)), `n${Math.floor(random() * 1e4)}`),
  title: (s) => edits.setField(s, { kind: "scene" }, "name", pick(["", "yard", "hall"])),
  bounds: (s) => edits.setField(s, { kind: "scene" }, "bounds", [-20, number() - 40, 40 + number(), 40]),
};
const [own, past] = made();
const shown = () => own.get().scene;
const text = () => JSON.stringify(own.get().scene);
const texts = [text()];
const done = {};
while (texts.length <= given.count) {
  const kind = pick(Object.keys(KINDS));
  const before = shown();
  let after;
  try {
    after = KINDS[kind](before);
  } catch (error) {
    if (!(error instanceof edits.EditError)) throw error;
    continue;
  }
  if (after === before) continue;
  if (random() < 0.3) {
    past.begin(kind);
    for (let k = 0; k < 3; k += 1) past.preview(edits.moved(before, some(before), number(), number()));
    past.preview(after);
    past.commit();
  } else past.change(kind, after);
  texts.push(text());
  done[kind] = (done[kind] ?? 0) + 1;
}
"""


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_500_random_edits_undone_one_by_one_give_back_the_first_scene_byte_for_byte(sheet: Page, seed: int) -> None:
    found = run(
        sheet,
        EDITING
        + """
        const failed = [];
        for (let k = given.count - 1; k >= 0; k -= 1) if (past.undo() === null || text() !== texts[k]) failed.push(k);
        const first = { text: text(), same: shown() === yard, dirty: own.get().file.dirty, more: past.undo() };
        for (let k = 1; k <= given.count; k += 1) if (past.redo() === null || text() !== texts[k]) failed.push(-k);
        return { failed, first, done, kinds: Object.keys(KINDS), more: past.redo(), last: text() === texts.at(-1) };
        """,
        seed=seed,
        count=500,
    )
    assert found["failed"] == []
    assert found["first"] == {
        "text": json.dumps(SCENE, separators=(",", ":")),
        "same": True,
        "dirty": False,
        "more": None,
    }
    assert found["more"] is None
    assert found["last"]
    assert set(found["done"]) == set(found["kinds"]), "every kind of edit took place"


def test_whatever_edits_make_is_a_scene_that_a_file_gives_back_as_it_is(sheet: Page) -> None:
    written, read = run(
        sheet,
        EDITING
        + """
        const { text: file } = await studio.link.ask("text", { scene: shown(), format: "json" }).promise;
        const { scene: read } = await studio.link.ask("open", { text: file, name: "yard.json" }).promise;
        return [shown(), read];
        """,
        seed=5,
        count=120,
    )
    written.setdefault("name", "")
    read.setdefault("name", "")
    assert read == written
    assert [list(entry) for entry in read["robots"]] == [list(entry) for entry in written["robots"]]


def test_edits_share_what_they_do_not_change_and_freeze_what_they_make(sheet: Page) -> None:
    found = run(
        sheet,
        """
        const after = edits.moved(yard, [obstacle("O1")], 1, 0);
        const mutable = (value) => typeof value === "object" && value !== null
          && (!Object.isFrozen(value) || Object.values(value).some(mutable));
        return {
          others: after.obstacles.slice(1).every((entry, k) => entry === yard.obstacles[k + 1]),
          robots: after.robots === yard.robots,
          mutable: mutable(after),
          before: JSON.stringify(yard) === JSON.stringify(given.scene),
          idle: edits.moved(yard, [obstacle("O1")], 0, 0) === yard,
        };
        """,
    )
    assert found == {"others": True, "robots": True, "mutable": False, "before": True, "idle": True}


def test_a_drag_is_one_step_and_escape_or_undo_gives_it_up(sheet: Page) -> None:
    found = run(
        sheet,
        """
        const [own, past] = made();
        const drag = (dx) => past.preview(edits.moved(past.base(), [obstacle("O1")], dx, 0));
        const at = () => own.get().scene.obstacles[0].polygon[0][0];
        past.begin("move O1");
        for (const dx of [0.1, 0.2, 0.3]) drag(dx);
        past.commit();
        const one = [at(), past.labels(), own.get().history, own.get().file.dirty];
        past.begin("move O1");
        drag(5);
        past.abandon();
        const abandoned = [at(), past.labels().undo.length, past.dragging()];
        past.begin("move O1");
        drag(7);
        const undone = [past.undo(), at(), past.labels(), own.get().file.dirty];
        past.begin("move O1");
        past.commit();
        return { one, abandoned, undone, empty: past.labels().undo };
        """,
    )
    labels = {"undo": ["move O1"], "redo": []}
    assert found["one"] == [6.3, labels, {"undo": "move O1", "redo": None}, True]
    assert found["abandoned"] == [6.3, 1, False]
    assert found["undone"] == ["move O1", 6, {"undo": [], "redo": ["move O1"]}, False]
    assert found["empty"] == []


def test_history_knows_what_is_saved_what_is_selected_and_when_a_new_document_begins(sheet: Page) -> None:
    found = run(
        sheet,
        """
        const [own, past] = made();
        own.set({ selection: [obstacle("O1"), robot("R1")] });
        past.change("delete O1", edits.removed(yard, [obstacle("O1")]));
        const gone = own.get().selection;
        past.markSaved();
        const saved = own.get().file.dirty;
        past.undo();
        const before = [own.get().file.dirty, own.get().selection, own.get().revision];
        past.changeUnderlay("lay a picture under", { name: "plan.png", x: 0 });
        const pictured = [own.get().underlay, own.get().revision, past.labels().undo];
        past.replaceAll({ scene: scene.emptyScene(), file: { name: "new.yaml", path: null } });
        return { gone, saved, before, pictured, fresh: [past.labels(), own.get().file, own.get().underlay] };
        """,
    )
    assert found["gone"] == [{"kind": "robot", "name": "R1"}]
    assert found["saved"] is False
    assert found["before"] == [True, [{"kind": "obstacle", "name": "O1"}, {"kind": "robot", "name": "R1"}], 2]
    assert found["pictured"] == [{"name": "plan.png", "x": 0}, 2, ["lay a picture under"]]
    assert found["fresh"] == [{"undo": [], "redo": []}, {"name": "new.yaml", "path": None, "dirty": False}, None]


def test_shapes_stay_what_they_are_until_a_corner_of_theirs_is_edited(sheet: Page) -> None:
    found = run(
        sheet,
        """
        const named = (s, name) => scene.obstacleNamed(s, name);
        const all = [obstacle("table"), obstacle("pillar"), obstacle("wall-09")];
        const turned = edits.rotated(yard, all, 0.5);
        const own = edits.rotated(yard, [obstacle("table")], 0.5);
        const back = edits.rotated(own, [obstacle("table")], -0.5);
        const box = { kind: "workspace" };
        return {
          kinds: all.map(({ name }) => scene.shapeOf(named(turned, name))),
          own: named(own, "table"),
          back: named(back, "table"),
          warned: edits_outline.becomesPolygon(yard, obstacle("table")),
          corner: named(edits_outline.setVertex(yard, obstacle("table", 2), [5, 5]), "table"),
          wall: named(edits_outline.insertVertex(yard, obstacle("wall-09"), 0, [11, 9]), "wall-09"),
          wider: edits_outline.edgeMoved(yard, box, 1, 2, 0).bounds,
          bent: [edits_outline.setVertex(yard, { ...box, vertex: 2 }, [15, 15])].map((s) => [s.bounds, s.workspace])[0],
          order: Object.keys(edits_outline.setVertex(yard, { ...box, vertex: 2 }, [15, 15])),
        };
        """,
    )
    assert found["kinds"] == ["rectangle", "circle", "line"]
    assert found["own"] == {"name": "table", "rectangle": [2, 3, 2, 1], "angle": 0.5}
    assert found["back"] == {"name": "table", "rectangle": [2, 3, 2, 1]}
    assert found["warned"] is True
    assert found["corner"] == {"name": "table", "polygon": [[2, 3], [4, 3], [5, 5], [2, 4]]}
    assert found["wall"] == {"name": "wall-09", "line": [[10, 8], [11, 9], [12, 8], [12, 10]], "width": 0.2}
    assert found["wider"] == [0, 0, 18, 12]
    assert found["bent"] == [None, [[0, 0], [16, 0], [15, 15], [0, 12]]]
    assert found["order"] == [key if key != "bounds" else "workspace" for key in SCENE]


def test_a_turned_rectangle_has_the_corners_that_planning_gives_it(sheet: Page) -> None:
    corners = run(
        sheet, "return scene.outlineOf({ name: 'shelf', rectangle: [1.5, -2, 4, 0.5], angle: given.angle });", angle=0.7
    )
    expected = Rectangle(1.5, -2, 4, 0.5, 0.7).core
    for corner, own in zip(corners, expected.tolist(), strict=True):
        assert corner == pytest.approx(own, abs=1e-14)


def test_things_moved_to_and_fro_leave_no_dust(sheet: Page) -> None:
    found = run(
        sheet,
        """
        let out = yard;
        for (let k = 0; k < 30; k += 1) out = edits.moved(out, [obstacle("pillar"), robot("R1")], 0.1, -0.7);
        const far = [scene.obstacleNamed(out, "pillar").circle, out.robots[0].start];
        for (let k = 0; k < 30; k += 1) out = edits.moved(out, [obstacle("pillar"), robot("R1")], -0.1, 0.7);
        const quarter = [1, 2, 3, 4].reduce((s) => edits.rotated(s, [obstacle("O1"), robot("R2")], Math.PI / 2), yard);
        const { sum } = edits_numbers;
        return { far, back: JSON.stringify(out) === JSON.stringify(yard),
          quarter: JSON.stringify(quarter) === JSON.stringify(yard),
          sums: [sum(4.6, 0.1), sum(1e-9, 3), sum(1e15, 0.1), sum(1 / 3, 0.1), sum(-0.3, 0.1)] };
        """,
    )
    assert found["far"] == [[15, -16.4], [4, -20]]
    assert found["back"]
    assert found["quarter"]
    assert found["sums"] == [4.7, 3.000000001, 1e15 + 0.1, 1 / 3 + 0.1, -0.2]


def test_several_things_move_together_and_a_whole_outweighs_its_parts(sheet: Page) -> None:
    found = run(
        sheet,
        """
        const refs = [obstacle("O1"), obstacle("O1", 0), robot("R1"), { kind: "start", name: "R1" },
          { kind: "goal", name: "R2" }, obstacle("wall-09", 1)];
        const out = edits.moved(yard, refs, 1, 0);
        return [scene.obstacleNamed(out, "O1").polygon, out.robots[0].start, out.robots[0].goal, out.robots[1].start,
          out.robots[1].goal, scene.obstacleNamed(out, "wall-09").line];
        """,
    )
    wall = [[10, 8], [13, 8], [12, 10]]
    assert found == [[[7, 6], [9, 7], [7.5, 9]], [2, 1], [15, 10], [1, 10], [15, 2], wall]


def test_copies_have_fresh_names_and_lie_behind_the_others(sheet: Page) -> None:
    found = run(
        sheet,
        """
        const { scene: out, refs } = edits.duplicated(yard, [robot("R1"), obstacle("table"), obstacle("O1"),
          obstacle("wall-09")], 0.5, -0.5);
        const twice = edits.duplicated(out, [obstacle("table"), obstacle("O1")], 1, 1);
        return { names: out.obstacles.map(({ name }) => name), robots: out.robots.at(-1), refs,
          table: scene.obstacleNamed(out, "table-2"), twice: twice.refs.map(({ name }) => name),
          added: edits.addObstacle(yard, { circle: [1, 2], radius: 1 }).obstacles.at(-1).name };
        """,
    )
    assert found["names"] == ["O1", "table", "pillar", "wall-09", "O2", "table-2", "wall-10"]
    assert found["robots"] == {**SCENE["robots"][0], "name": "R3", "start": [1.5, 0.5], "goal": [14.5, 9.5]}
    assert [ref["name"] for ref in found["refs"]] == ["O2", "table-2", "wall-10", "R3"]
    assert found["table"] == {"name": "table-2", "rectangle": [2.5, 2.5, 2, 1]}
    assert found["twice"] == ["O3", "table-3"]
    assert found["added"] == "O2"


def test_corners_and_things_are_removed_together(sheet: Page) -> None:
    found = run(
        sheet,
        """
        const five = edits_outline.insertVertex(
          edits_outline.insertVertex(yard, obstacle("O1"), 2, [6, 8]), obstacle("O1"), 0, [7, 6]);
        const out = edits.removed(five, [obstacle("O1", 1), obstacle("O1", 4), obstacle("pillar"),
          { kind: "start", name: "R1" }, { kind: "workspace" }]);
        return [scene.obstacleNamed(five, "O1").polygon.length, scene.obstacleNamed(out, "O1").polygon,
          out.obstacles.map(({ name }) => name), out.robots.map(({ name }) => name), out.bounds];
        """,
    )
    polygon = SCENE["obstacles"][0]["polygon"]
    assert found == [5, polygon, ["O1", "table", "wall-09"], ["R2"], SCENE["bounds"]]


@pytest.mark.parametrize(
    ("edit", "sentence"),
    [
        (
            "edits.renamed(yard, obstacle('O1'), 'table')",
            "There is another obstacle named table; every name must be unique.",
        ),
        ("edits.renamed(yard, robot('R1'), '  ')", "Every robot needs a name."),
        ("edits.renamed(yard, robot('R9'), 'R1')", "There is no robot R9 any more."),
        ("edits.addObstacle(yard, {name: 'O1', circle: [0, 0], radius: 1})", "There is another obstacle named O1; "),
        ("edits.addObstacle(yard, {circle: [0, 0], radius: 0})", "O2: radius must be more than zero, not 0."),
        (
            "edits.addObstacle(yard, {polygon: [[0, 0], [1, NaN], [1, 1]]})",
            "O2: a corner: y must be a number, not NaN.",
        ),
        ("edits.addObstacle(yard, {polygon: [[0, 0], [1, 1]]})", "O2: a polygon needs at least 3 corners."),
        ("edits.addRobot(yard, {start: [0, 0], goal: [1, 1], radius: -1})", "R3: radius must not be negative, not -1."),
        ("edits.setField(yard, robot('R1'), 'speed', 0)", "R1: speed must be more than zero, not 0."),
        ("edits.setField(yard, robot('R1'), 'at_goal', 'fly')", "R1: at goal must be stay or leave, not “fly”."),
        ("edits.setField(yard, obstacle('table'), 'radius', 1)", "table has no field radius."),
        ("edits.setField(yard, {kind: 'scene'}, 'bounds', [0, 0, -1, 4])", "Bounds need xmin < xmax, not 0 and -1."),
        ("edits.setField(yard, {kind: 'scene'}, 'gap', -0.1)", "Gap must not be negative, not -0.1."),
        ("edits_outline.removeVertex(yard, obstacle('O1', 1))", "An outline needs at least 3 corners; "),
        ("edits_outline.removeVertex(yard, obstacle('O1', 3))", "That corner is not there any more."),
        ("edits_outline.setVertex(yard, obstacle('pillar', 0), [1, 1])", "pillar is a circle: it has no corners."),
        ("edits_outline.insertVertex(yard, obstacle('wall-09'), 2, [1, 1])", "That side is not there any more."),
        ("edits_outline.resized(yard, obstacle('O1'), 0, [1, 1])", "O1 has no handles: its corners are moved instead."),
    ],
)
def test_what_cannot_be_is_refused_in_one_sentence(sheet: Page, edit: str, sentence: str) -> None:
    assert str(run(sheet, f"return wrong(() => {edit});")).startswith(sentence)


def test_fields_are_set_as_files_hold_them(sheet: Page) -> None:
    found = run(
        sheet,
        """
        const set = (ref, field, value) => edits.setField(yard, ref, field, value);
        const named = (s, name) => scene.obstacleNamed(s, name);
        return {
          circle: named(set(obstacle("pillar"), "x", 3), "pillar").circle,
          rectangle: named(set(obstacle("table"), "width", 0.7), "table").rectangle,
          angle: [Math.PI * 3, 0].map((angle) => named(set(obstacle("table"), "angle", angle), "table")),
          polygon: named(set(obstacle("O1"), "y", 0), "O1").polygon,
          clearance: [null, 0.4].map((value) => set(robot("R2"), "clearance", value).robots[1]),
          options: [["start_time", 3], ["at_goal", "leave"]].map(([f, v]) => set(robot("R2"), f, v).robots[1]),
          goal: set({ kind: "goal", name: "R1" }, "y", 4).robots[0].goal,
          name: [Object.keys(set({ kind: "scene" }, "name", "")), Object.keys(set({ kind: "scene" }, "name", "a"))],
        };
        """,
    )
    second = SCENE["robots"][1]
    assert found["circle"] == [3, 4.6]
    assert found["rectangle"] == [2, 3, 0.7, 1]
    assert found["angle"][0]["angle"] == pytest.approx(math.pi)
    assert "angle" not in found["angle"][1]
    assert found["polygon"] == [[6, 0], [8, 1], [6.5, 3]]
    assert found["clearance"] == [
        {key: second[key] for key in second if key != "clearance"},
        {**second, "clearance": 0.4},
    ]
    assert [list(entry)[5:] for entry in found["options"]] == [["clearance", "start_time"], ["clearance", "at_goal"]]
    assert found["goal"] == [14, 4]
    assert found["name"] == [[key for key in SCENE if key != "name"], list(SCENE)]


def test_handles_draw_sizes_and_keep_what_lies_opposite(sheet: Page) -> None:
    found = run(
        sheet,
        """
        const size = (s, name, handle, point) => scene.obstacleNamed(
          edits_outline.resized(s, obstacle(name), handle, point), name);
        const turned = edits.setField(yard, obstacle("table"), "angle", 0.4);
        const drawn = edits_outline.resized(turned, obstacle("table"), 2, [5, 6]);
        const at = (s, k) => scene.outlineOf(scene.obstacleNamed(s, "table"))[k];
        return {
          corner: size(yard, "table", 2, [4.6, 5]).rectangle,
          side: size(yard, "table", 7, [1.3, 99]).rectangle,
          over: size(yard, "table", 5, [1, 0]).rectangle,
          none: size(yard, "table", 5, [2, 0]).rectangle,
          radius: size(yard, "pillar", 0, [12.7, 4.6]).radius,
          bounds: edits_outline.resized(yard, { kind: "workspace" }, 0, [-1, -2]).bounds,
          fixed: [at(turned, 0), at(drawn, 0)], drawn: at(drawn, 2),
          handles: ["table", "pillar", "O1"].map((name) => edits_outline.handlesOf(yard, obstacle(name))),
        };
        """,
    )
    assert found["corner"] == [2, 3, 2.6, 2]
    assert found["side"] == [1.3, 3, 2.7, 1]
    assert found["over"] == [1, 3, 1, 1]
    assert found["none"] == [2, 3, 2, 1]
    assert found["radius"] == 0.7
    assert found["bounds"] == [-1, -2, 16, 12]
    assert found["fixed"][0] == pytest.approx(found["fixed"][1], abs=1e-11)
    assert found["drawn"] == pytest.approx([5, 6], abs=1e-11)
    assert found["handles"][0][4:6] == [[3, 3], [4, 3.5]]
    assert found["handles"][1:] == [[[12.5, 4.6]], []]


def test_what_is_under_a_point_or_in_a_box_is_found_topmost_first(sheet: Page) -> None:
    found = run(
        sheet,
        """
        const crowded = edits.addObstacle(edits.addObstacle(yard, { circle: [1, 1], radius: 2 }),
          { rectangle: [0.5, 0.5, 1, 1], angle: 0.3 });
        const names = (refs) => refs.map(({ kind, name }) => `${kind} ${name ?? ""}`.trim());
        return {
          top: names(scene_hits.hitsAt(crowded, [1.1, 1], 0.05)),
          wall: names(scene_hits.hitsAt(yard, [11, 8.12], 0.03)),
          edge: names(scene_hits.hitsAt(yard, [15.98, 6], 0.05)),
          nothing: names(scene_hits.hitsAt(yard, [5, 5], 0.1)),
          box: names(scene_hits.refsInBox(yard, [12.3, 4, 15, 11])),
          through: names(scene_hits.refsInBox(yard, [6.9, 7, 7, 7.1])),
          side: scene_hits.edgeAt(yard, obstacle("wall-09"), [12.05, 9], 0.1),
          off: scene_hits.edgeAt(yard, obstacle("wall-09"), [11, 9], 0.1),
        };
        """,
    )
    assert found["top"] == ["start R1", "obstacle O3", "obstacle O2"]
    assert found["wall"] == ["obstacle wall-09"]
    assert found["edge"] == ["workspace"]
    assert found["nothing"] == []
    assert found["box"] == ["obstacle pillar", "goal R1"]
    assert found["through"] == ["obstacle O1"]
    assert found["side"] == {"edge": 1, "point": [12, 9]}
    assert found["off"] is None


ALL = {"grid": True, "step": 0.5, "vertex": True, "edge": True, "angle": True}
FREE = {"grid": False, "step": None, "vertex": False, "edge": False, "angle": False}


@pytest.mark.parametrize(
    ("point", "snap", "options", "expected"),
    [
        ([8.06, 7.1], ALL, {}, [8, 7]),  # a corner before the side and the grid
        ([3.2, 3.06], ALL, {}, [3, 3]),  # a side, and the grid along it
        ([7.1, 6.5], ALL, {}, [7.08, 6.54]),  # a slanted side, to the digits of a pixel
        ([2.06, 8.33], ALL, {}, [2, 8.5]),  # above a corner, and the grid upwards
        ([9.9, 8.33], ALL, {}, [10, 8.5]),  # the grid
        ([9.913333, 8.33777], FREE, {}, [9.91, 8.34]),  # nothing
        ([8.06, 7.1], ALL, {"except": [{"kind": "obstacle", "name": "O1"}]}, [8, 7]),  # what moves does not draw itself
        ([5, 4.9], FREE, {"from": [3, 3], "constrain": True}, [4.952, 4.952]),  # 45°
        ([5, 3.1], FREE, {"from": [3, 3.3], "constrain": True}, [4.99, 3.3]),  # level: its own y stays
        ([5, 5.2], ALL, {"from": [3, 3], "constrain": True}, [5.121, 5.121]),  # whole steps along the ray
    ],
)
def test_a_place_snaps_to_what_is_meant(sheet: Page, point: Any, snap: Any, options: Any, expected: Any) -> None:
    found = run(
        sheet,
        "return snapping.snapped(given.point, yard, given.snap, { scale: 50 }, given.options);",
        point=point,
        snap=snap,
        options=options,
    )
    assert found["point"] == pytest.approx(expected, abs=0.0101)
    if "constrain" not in options:
        assert found["point"] == expected


def test_without_a_step_of_its_own_the_grid_is_the_one_drawn(sheet: Page) -> None:
    found = run(
        sheet,
        """
        const { gridSteps } = await import("studio/grid.js");
        return [3, 20, 170, 9e4].map((scale) => {
          const { point } = snapping.snapped([9.9137, 5.33], yard, { ...given.free, grid: true }, { scale });
          const { fine } = gridSteps(scale);
          return Math.max(...point.map((x, axis) => Math.abs(x - Math.round([9.9137, 5.33][axis] / fine) * fine)));
        });
        """,
        free=FREE,
    )
    assert max(found) < 1e-12


def test_a_move_snaps_by_the_point_that_is_drawn_best(sheet: Page) -> None:
    found = run(
        sheet,
        """
        const camera = { scale: 50 };
        const move = (name, dx, dy, snap) => snapping.snappedMove(yard, [obstacle(name)], dx, dy, snap, camera);
        return [move("table", 2.05, 2.04, given.all), move("table", 0.1234, 0.77, given.free),
          move("pillar", 0.33, 0.1, { ...given.free, grid: true, step: 0.5 }), move("table", 4.03, -1.3, given.all)];
        """,
        all=ALL,
        free=FREE,
    )
    corner, free, grid, line = found
    assert (corner["dx"], corner["dy"]) == (2, 2)  # its upper right corner comes to the polygon's first
    assert corner["guides"][0]["what"] == "vertex"
    assert (free["dx"], free["dy"]) == (0.12, 0.77)
    assert (grid["dx"], grid["dy"]) == (0.5, -0.1)  # the centre comes to (12.5, 4.5)
    assert line["dx"] == 4
    assert sorted((guide["from"][0], guide["to"]) for guide in line["guides"]) == [
        (6, [6, 1.5]),  # both of its sides lie under corners of the polygon
        (6, [6, 2.5]),
        (8, [8, 1.5]),
        (8, [8, 2.5]),
    ]


def test_snapping_among_5000_corners_finds_what_a_search_through_all_finds_and_takes_no_time(sheet: Page) -> None:
    found = run(
        sheet,
        """
        const random = throwing(7);
        const ring = (k) => Array.from({ length: 5 }, (_, i) =>
          [(k % 32) * 3 + Math.cos(i * 1.2) + random() * 0.3, Math.floor(k / 32) * 3 + Math.sin(i * 1.2)]);
        const crowd = scene.deepFreeze({ ...given.scene, bounds: [-2, -2, 98, 98], robots: [],
          obstacles: Array.from({ length: 1000 }, (_, k) => ({ name: `O${k}`, polygon: ring(k) })) });
        const camera = { scale: 20 };
        const only = { grid: false, step: null, vertex: true, edge: false, angle: false };
        const corners = [...scene.workspaceRing(crowd), ...crowd.obstacles.flatMap(scene.outlineOf)];
        const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
        const wrong_ = [];
        let caught = 0;
        for (let k = 0; k < 300; k += 1) {
          const at = [random() * 104 - 4, random() * 104 - 4];
          const nearest = corners.reduce((best, corner) => (apart(corner, at) < apart(best, at) ? corner : best));
          const { point, guides } = snapping.snapped(at, crowd, only, camera);
          const caughtIt = apart(nearest, at) <= 9 / 20;
          caught += caughtIt;
          if (caughtIt ? apart(point, nearest) !== 0 : guides.length !== 0) wrong_.push(at);
        }
        const every = { grid: true, step: 0.5, vertex: true, edge: true, angle: true };
        const before = performance.now();
        for (let k = 0; k < 500; k += 1) snapping.snapped([random() * 100, random() * 100], crowd, every, camera);
        return { wrong: wrong_, caught, milliseconds: (performance.now() - before) / 500 };
        """,
    )
    assert found["wrong"] == []
    assert found["caught"] > 30
    assert found["milliseconds"] < 2
