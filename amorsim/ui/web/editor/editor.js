// The Editor's page: a document that the server keeps, drawn and listed; every gesture is a step that can be undone.

import { h, say, there } from "../shared/dom.js";
import { Connection, lostWords } from "../shared/socket.js";
import { startTheme } from "../shared/theme.js";
import { Hand } from "../shared/tool.js";
import { readMenu } from "./adding.js";
import { askNumbers } from "./ask_numbers.js";
import { copyOf, keep, paste, put, remove } from "./clipboard.js";
import { CircleTool, LineTool, MeasureTool, RectangleTool } from "./draw_tools.js";
import { showText } from "./files.js";
import { Ghosts } from "./ghosts.js";
import { Inspector } from "./inspector.js";
import { listen } from "./keys.js";
import { DOINGS, build } from "./layout.js";
import { ObjectList, counts, faultButtons, faultsAndLacks } from "./list.js";
import { WALL_TOOLS, showOutside, showPen, showTools } from "./outside.js";
import { showMounts } from "./mounting.js";
import { BrushTool, FillTool, cropTool } from "./paint_tools.js";
import { askLines } from "./project.js";
import { SelectTool } from "./select_tool.js";
import { EditStage } from "./stage.js";
import { showTyping } from "./typing.js";
import { takeUp } from "./underlay.js";
import { DoorTool, RoomTool, TrimTool } from "./wall_tools.js";

const KEPT = "Your changes are kept.";

export class EditorPage {
  /** @param {HTMLElement} root */
  constructor(root) {
    this.root = root;
    this.toggleTheme = startTheme(root);
    this.stage = new EditStage(root);
    this.inspector = new Inspector(this);
    this.objects = new ObjectList(this);
    this.ghosts = new Ghosts(this);
    this.parts = build({ pane: this.stage.pane.element, objects: this.objects.element, inspector: this.inspector });
    root.replaceChildren(this.parts.element);
    this.grid = 0.1;
    this.width = 0.9; // [m] of openings
    this.brush = 0.1; // [m], how wide the brush is
    this.door = "swinging"; // what is put into them
    /** @type {any} */
    this.state = null;
    /** @type {any[]} */
    this.faults = [];
    this.window = "";
    /** Shows the faults of a program that is open. @type {(() => void) | null} */
    this.showCodeFaults = null;
    /** Closes the panel beside the drawing, where there is one. @type {(() => void) | null} */
    this.closeBeside = null;
    this.besideText = false; // whether it shows the scenario's text
    /** The simulation that is shown on the canvas. @type {any} */
    this.playing = null;
    /** What was read last. @type {any} */
    this.drawn = null;
    this.fitsNext = false; // whether all of the next world is to be seen
    this.wantedTool = ""; // which is taken once walls can be drawn
    this.outside = ""; // what is said of files that were changed by something else
    /** What can be added. @type {any[]} */
    this.kinds = [];
    /** Generators of worlds, by name. @type {string[]} */
    this.generators = [];
    /** @type {Record<string, any>} */
    this.tools = {
      select: new SelectTool(this), hand: this.stage.pane.panning, line: new LineTool(this, false), polyline: new LineTool(this, true),
      rectangle: new RectangleTool(this), circle: new CircleTool(this), room: new RoomTool(this), door: new DoorTool(this),
      trim: new TrimTool(this), brush: new BrushTool(this, { isOccupied: true }), eraser: new BrushTool(this, { isOccupied: false }),
      cells: new BrushTool(this, { isOccupied: true, isLine: true }), fill: new FillTool(this), crop: cropTool(this), measure: new MeasureTool(this),
    };
    this.stage.pane.panning = new Hand(this.stage.camera, {});
    this.stage.ask = (asks) => this.isHolder && askNumbers(this, asks);
    listen(this);
    this.stage.selection.listen(() => this.showDoings());
    this.take("select");
    this.connection = new Connection({
      frame: () => {},
      news: (/** @type {any} */ message) => message.window && (this.window = message.window),
      open: () => this.follow(),
      lost: (/** @type {number} */ attempts) => this.warn(lostWords(attempts, KEPT)),
    });
  }

  /** Whether this window holds the pen. */
  get isHolder() {
    return Boolean(this.window) && this.state?.holder === this.window && !this.playing;
  }

  get watching() {
    return !this.isHolder;
  }

  get wallsFixed() {
    return this.state?.walls_fixed ?? "";
  }

  // ------------------------------------------------------------------------------------------------------- following

  async follow() {
    this.warn("");
    const menu = await this.connection.ask({ do: "menu" });
    if (menu.ok) readMenu(this, menu);
    let number = 0;
    while (this.connection.isOpen) {
      const said = await this.connection.ask({ do: "document", after: number });
      if (!said.ok) break;
      number = said.number;
      this.show(said);
    }
  }

  /** @param {any} said */
  show(said) {
    const before = this.state;
    const wasWatching = this.watching;
    this.state = said;
    const { parts } = this;
    document.title = `${said.name}${said.is_saved ? "" : " •"} · amorsim`;
    say(parts.file, `${said.name}${said.is_saved ? "" : " •"}`);
    parts.file.title = said.file || `not saved yet; it will be saved in ${said.folder}`;
    say(parts.saved, said.is_new ? "not saved yet" : said.is_saved ? "saved" : "changed");
    parts.undo.disabled = !said.undo;
    parts.redo.disabled = !said.redo;
    parts.undo.title = said.undo ? `undo: ${said.undo} (Ctrl + Z)` : "undo (Ctrl + Z)";
    parts.redo.title = said.redo ? `redo: ${said.redo} (Ctrl + Y)` : "redo (Ctrl + Y)";
    this.showState();
    if (!before) takeUp(this);
    if (said.drawn) this.draw(said.drawn);
    else if (before && wasWatching !== this.watching) this.inspector.refresh();
  }

  /** Show who may change it, and which tools there are. */
  showState() {
    this.root.classList.toggle("watching", this.watching);
    showPen(this);
    showOutside(this);
    showTools(this);
  }

  /** @param {any} drawn */
  draw(drawn) {
    this.drawn = drawn;
    if (this.playing) return; // it is shown when that has ended
    const { things, still } = drawn;
    const [faults, lacks] = faultsAndLacks(drawn.faults, this.state.is_new);
    const { parts, stage } = this;
    this.faults = faults;
    if (this.toolName === "select") stage.preview = null;
    for (const stroke of stage.strokes) stroke.isRead ||= stroke.isKept && !this.state.is_behind;
    // First of all, for they take room from the drawing.
    parts.reading.hidden = true;
    const isRight = lacks.length ? `not yet: ${lacks.join(", ")}` : "no faults";
    say(parts.problems, faults.length === 1 ? "1 fault" : faults.length ? `${faults.length} faults` : isRight);
    parts.faults.hidden = !faults.length;
    parts.faults.replaceChildren(faultButtons(faults, (at) => this.goTo(at), (command) => this.connection.ask(command)));
    stage.update({ still, things }, (name) => this.image(name));
    const { walls } = stage.walls;
    this.objects.show(lacks.length ? things.map((/** @type {import("./stage.js").Thing} */ thing) => (thing.path === "world" ? { ...thing, faults: 0 } : thing)) : things, walls);
    counts(parts.counts, things, walls);
    if (this.wanted) this.choose(this.wanted.paths, this.wanted.walls);
    if (this.fitsNext) stage.fit();
    this.fitsNext = false;
    this.showCodeFaults?.();
    this.ghosts.ask();
  }

  /** Select things, and walls that come last, once they are there.
   * @param {string[]} paths
   * @param {{first: number, count: number}} [walls] */
  choose(paths, walls = { first: 0, count: 0 }) {
    const { stage } = this;
    const things = stage.things.filter(({ path }) => paths.includes(path)).map((thing) => stage.chosenOf(thing));
    const isThere = things.length >= paths.length && stage.walls.walls.length >= walls.first + walls.count;
    this.wanted = isThere ? null : { paths, walls };
    const lines = isThere ? Array.from({ length: walls.count }, (_, n) => stage.chosenWall(walls.first + n)) : [];
    if (things.length || lines.length) stage.selection.set([...things, ...lines]);
  }

  /** Show what a fault is about. @param {string} at */
  goTo(at) {
    const thing = this.stage.things.filter(({ path }) => at === path || at.startsWith(`${path}.`))[0];
    if (thing) this.stage.selection.set([this.stage.chosenOf(thing)]);
    else showText(this);
  }

  /** @param {string} name */
  async image(name) {
    const said = await this.connection.ask({ do: "image", name });
    return said.ok ? `data:image/png;base64,${said.png}` : null;
  }

  /** What can be done with what is selected. */
  showDoings() {
    const some = this.stage.selection.things.some((one) => one.kind !== "settings");
    for (const [name] of DOINGS) this.parts[name].disabled = !some;
    if (this.toolName === "select") this.showTool(this.tools.select);
    showMounts(this);
  }

  // --------------------------------------------------------------------------------------------------------- changing

  /** Change the document, as one step; an error is shown.
   * @param {string} label
   * @param {any[]} changes */
  async edit(label, changes) {
    const said = await this.connection.ask({ do: "edit", label, changes });
    if (!said.ok) {
      this.hint(said.error);
      this.stage.putBack();
    } else this.hint(label);
    return said;
  }

  /** @param {string} which */
  async step(which) {
    const said = await this.connection.ask({ do: which });
    this.hint(said.ok ? (said.label ? `${which}: ${said.label}` : `nothing to ${which}`) : said.error);
  }

  async copy(isCut = false) {
    const found = await copyOf(this);
    if (!found) return;
    this.clip = found;
    keep(found);
    this.hint(`${isCut ? "cut" : "copied"} ${found.count === 1 ? "1 thing" : `${found.count} things`}`);
    if (isCut) await remove(this);
  }

  /** @param {{x: number, y: number}} [at] where to, if not beside what was copied */
  paste(at) {
    return paste(this, at);
  }

  async duplicate() {
    const clip = await copyOf(this);
    if (clip) await put(this, "duplicate", clip);
  }

  // ----------------------------------------------------------------------------------------------------------- tools

  /** Take a tool in hand. @param {string} name */
  take(name) {
    const { hidden, disabled } = there(this.parts.tools.get(name));
    if (hidden) return;
    if (disabled) this.hint("another window holds the pen");
    else if (this.wallsFixed && WALL_TOOLS.includes(name)) askLines(this, name);
    else this.hold(this.tools[name], name);
  }

  /** @param {any} tool */
  hold(tool, name = "") {
    for (const [other, button] of this.parts.tools) button.setAttribute("aria-pressed", String(other === name));
    this.stage.pane.take(tool);
    this.stage.preview = null;
    this.stage.redraw();
    this.toolName = name;
    this.showTool(tool);
    showTyping(this.parts, tool);
    this.parts.openings.hidden = !["room", "door"].includes(name);
    this.parts.doors.hidden = name !== "door";
    this.parts.brushes.hidden = !["brush", "eraser", "cells"].includes(name);
    showMounts(this);
  }

  /** Say what a tool does next.
   * @param {any} tool */
  showTool(tool) {
    const words = tool.says ?? "Drag moves the view.";
    say(this.parts.says, words);
    this.parts.says.title = words;
  }

  /** How what is drawn snaps now.
   * @param {{altKey: boolean, shiftKey: boolean}} event
   * @param {number[] | null} from */
  snapping(event, from) {
    return { scale: this.stage.camera.scale, grid: this.grid, from, isTurned: event.shiftKey, isFree: event.altKey };
  }

  // ------------------------------------------------------------------------------------------------------------ words
  /** @param {string} text */
  hint(text) {
    say(this.parts.hint, text);
    this.parts.hint.title = text;
  }

  /** @param {string} text
   * @param {(HTMLElement | string)[]} buttons */
  warn(text, ...buttons) {
    const { banner } = this.parts;
    banner.hidden = !text;
    banner.className = "banner problem";
    banner.replaceChildren(h("span", { class: "text" }, text), ...buttons);
  }
}

const root = /** @type {HTMLElement & {editor?: EditorPage}} */ (document.querySelector(".amorsim"));
root.editor = new EditorPage(root);
