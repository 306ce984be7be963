// Made by tools/make_wire.py from what amorsim/ui/{scene, simulator, faults} say: change it there.

/** A moment, of one robot all; `sensors` are its readings. */
export interface Frame {
  version: number; number: number; epoch: number; time: number; speed: number; achieved: number; tick: number;
  newest: number; states: number; events: number; robotCount: number; obstacleCount: number; selected: number;
  valueCount: number; sensorCount: number; jointCount: number; channelCount: number; oldest: number; partCount: number;
  particleCount: number; hypothesisCount: number; trueValues: Float64Array; measuredValues: Float64Array;
  ages: Float64Array; trueRates: Float64Array; measuredRates: Float64Array; trueTwist: Float64Array;
  estimatedTwist: Float64Array; command: Float64Array; believedParts: Float64Array; particles: Float64Array;
  hypotheses: Float64Array; truePoses: Float32Array; estimatedPoses: Float32Array; covariances: Float32Array;
  obstacles: Float32Array; flags: Uint8Array; sensors: {true: Float64Array, measured: Float64Array, age: number}[]
}

export type CommandName =
  "state" | "scene" | "parameters" | "history" | "events" | "manual" | "image" | "mapped" | "intended" | "folder" |
  "select" | "controls" | "run" | "pause" | "step" | "speed" | "reset" | "scrub" | "continue" | "go_back" | "futures" |
  "forget" | "replica" | "hand_over" | "drive" | "command" | "stop" | "set" | "restore" | "noises" | "add" | "remove" |
  "places" | "page" | "save_scenario" | "save_run" | "restart" | "reload";

/** What a window asks for. */
export interface Command { do: CommandName; [key: string]: unknown }

/** A channel of a drive's command, or of a device that takes commands. */
export interface Channel { name: string; unit: string; low: number | null; high: number | null }

/** How readings are drawn; `style` is always there, and of the other keys those that the style needs. */
export interface Drawing {
  style?: string; half_angle?: number; reach?: number; span?: number[]; lines?: number[][][]; colours?: string[];
  names?: string[]
}

/** Things in the world other than walls and bodies; robots may know of them or not. */
export interface Floor { landmarks: number[][]; lights: number[][]; zones: number[][][]; patches: FloorPatch[] }

/** A line or an area on the floor, as `amorsim.core.patches.Patch`. */
export interface FloorPatch { points: number[][]; width: number; colour: string }

/** A picture of a map; `name` is for the command ``image``. Occupied cells are black, free ones clear. */
export interface Image { name: string; extent: number[] }

/** The properties that robots of one kind share. */
export interface Kind {
  model: string; drive: string; footprint: Outline; wheels: number[][]; channels: Channel[]; joints: string[];
  twist: number[]; sensors: SensorShape[]; estimators: string[]
}

/** The world as a robot knows it. */
export interface Knowledge { map: number | null; landmarks: number[][] }

/** A map to draw: lines, or a picture if it has none. */
export interface MapShape {
  name: string; origin: number[]; size: number[]; extent: number[]; segments: number[][] | null; image: Image | null
}

/** An obstacle, or after all of those a part of a robot. */
export interface ObstacleShape { name: string; footprint: Outline; moves: boolean; part_of: string; colour: string }

/** A footprint in its body's frame: a circle about the base point, or a polygon. */
export interface Outline { circle?: number; polygon?: number[][] }

/** A robot or an obstacle of which only the outline and the pose could be read. */
export interface OutlineShape { name: string; footprint: Outline; pose: number[] }

/** The page's description of a recorded run. */
export interface Recorded { replica: number; replicas: number[]; log: string; facts: string[][]; lacks: string[] }

/** A robot: `kind` is a place in the scene's `kinds`. */
export interface RobotEntry { name: string; kind: number; controller: string; knowledge: Knowledge; colour: string }

/** Everything that does not change while a simulation runs. `map` and knowledge are places in `maps`. */
export interface Scene {
  version: number; scenario: string; dt: number; duration: number; seed: number; maps: MapShape[]; map: number | null;
  kinds: Kind[]; robots: RobotEntry[]; obstacles: ObstacleShape[]; floor: Floor; recorded: Recorded
}

/** A sensor as it is drawn, by its nominal parameters; in an answer to ``parameters``, by its true ones. */
export interface SensorShape {
  name: string; kind: string; unit: string; columns: string[][]; size: number; mounts: number[][];
  bearings: number[] | null; range_max: number | null; half_angle: number | null; drawing: Drawing | null
}

/** A scenario at rest: what can be drawn of it without a simulation. */
export interface Still {
  scene: Scene; robots: (number[] | null)[]; obstacles: (number[] | null)[]; outlines: OutlineShape[]; extent: number[]
}

/** A chain of noise, in order; `group` is that of its fields. `gone` are elements that the scenario has in it. */
export interface ChainForm { path: string; group: string; elements: ElementForm[]; gone: string[] }

/** A parameter of a robot that was set while the simulation ran, and the value set last. */
export interface ChangedParameter { path: string; value: any }

/** An element of a chain: its name, its class's name, and whether it is not in the scenario. */
export interface ElementForm { name: string; use: string; path: string; is_added: boolean }

/** Something that happened; `number` counts from 1 within an epoch. */
export interface EventLine {
  number: number; tick: number; time: number; kind: string; robot: string; text: string; point: number[] | null;
  stack: string; is_told: boolean
}

/** A field of a form. `fixed` is the reason why its value cannot change now, and empty where it can. */
export interface FieldForm {
  path: string; label: string; help: string; widget: Widget; value: any; default: any; is_given: boolean;
  is_required: boolean; fixed: string
}

/** A course of events that was left by going on from its past: a robot's path in it, as in `History`. */
export interface Future {
  number: number; since: number; newest: number; changes: ChangedParameter[]; ticks: number[]; true: number[][];
  estimated: number[][]; past: Past
}

/** A robot's true and estimated path, and what else is known of its past. */
export interface History {
  ok: boolean; epoch: number; ticks: number[]; true: ((number | null)[])[]; estimated: number[][]; past: Past
}

/** The intentions of a controller in the last step; null where it has no such belief. */
export interface Intended {
  pose: number[]; path: number[][] | null; searched: number[][] | null; arcs: IntendedArc[] | null;
  blocked: boolean[] | null; bearing: number[] | null; ways: number[][] | null; velocities: IntendedVelocities | null
}

/** A way that a controller compared: points in the world [m], from the robot on. */
export interface IntendedArc { points: number[][]; worth: number; taken: boolean }

/** The bodies that a controller knows of, and the velocities that lead into them, in the robot's frame. */
export interface IntendedVelocities {
  speed: number; twist: number[]; others: number[][]; borders: number[][]; cones: number[][]
}

/** The map of an estimator, in the world [m]; parts that it has no belief of are missing. */
export interface Mapped {
  estimator: string; map: MappedCells | null; scan: number[][] | null; poses: number[][] | null;
  edges: number[][] | null
}

/** A picture of a map that an estimator has drawn: the more probable a wall, the more opaque. */
export interface MappedCells { extent: number[]; png: string }

/** A parameter of a part of a robot, as a form shows it while the simulation runs. */
export interface ParameterForm {
  path: string; group: string; part: string; label: string; unit: string; help: string; type: string; widget: Widget;
  low: number | null; high: number | null; is_open: boolean[]; slider: number[]; value: any; scenario: any;
  is_changed: boolean; is_added: boolean; fixed: string; drawn: string; drawn_value: number | null;
  nominal: number | null; true: number | null; deviation: FieldForm[]; kind: string; origin: string; source: string
}

/** The further values of a robot in plots: since it was first looked at, or since the start where robots are few. */
export interface Past { ticks: number[]; values: string }

/** The state of the simulation. */
export interface State {
  ok: boolean; version: number; epoch: number; status: string; tick: number; newest: number; time: number;
  speed: number | null; achieved: number; selected: number; by_hand: string[]; can_continue: boolean; reason: string;
  fault: EventLine | null; damage: string; holder: string; changed: boolean; moved: string
}

/** A number in a list that has no error yet and may be given one. */
export interface TargetForm { path: string; label: string }

/** How a value is shown and changed. */
export interface Widget {
  kind: string; is_optional: boolean; unit: string; low: number | null; high: number | null; is_open: boolean[];
  is_whole: boolean; choices: string[]; refers: string; component: string; frame: string; item: Widget;
  columns: string[]; length: number | null; fields: FieldForm[]; options: Widget[]
}

/** A fault: its place, the value there, and what is wrong with it. */
export interface FaultLine {
  file: string; line: number | null; said: string; path: string; value: string; message: string; remedy: string
}

/** The state of a scenario's file: the answer to ``document``. */
export interface FaultyFile {
  ok: boolean; number: number; status: string; file: string; faults: FaultLine[]; still: Still | null; path: string
}
