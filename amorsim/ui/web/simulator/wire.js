// Made by tools/make_wire.py from what amorsim/ui/{scene, simulator, faults} say: change it there.

/** How the simulation stands in a frame. */
export const FLAG = { running: 1, ended: 2, scrubbed: 4, fault: 8, hang: 16, loading: 32, posesOnly: 64 };

/** How a robot stands in a frame. */
export const ROBOT = { touching: 1, ended: 2, byHand: 4 };

export const MAGIC = 0x31666d61; // the first four bytes, little endian
export const HEADER_SIZE = 96; // bytes

/** Where the numbers of a frame's header lie: name, kind, byte.
 * @type {[string, "Uint32" | "Int32" | "Float32" | "Float64", number][]} */
export const HEADER = [
  ["version", "Uint32", 4],
  ["number", "Uint32", 8],
  ["epoch", "Uint32", 12],
  ["time", "Float64", 16],
  ["speed", "Float32", 24],
  ["achieved", "Float32", 28],
  ["tick", "Uint32", 32],
  ["newest", "Uint32", 36],
  ["states", "Uint32", 40],
  ["events", "Uint32", 44],
  ["robotCount", "Uint32", 48],
  ["obstacleCount", "Uint32", 52],
  ["selected", "Int32", 56],
  ["valueCount", "Uint32", 60],
  ["sensorCount", "Uint32", 64],
  ["jointCount", "Uint32", 68],
  ["channelCount", "Uint32", 72],
  ["oldest", "Uint32", 76],
  ["partCount", "Uint32", 80],
  ["particleCount", "Uint32", 84],
  ["hypothesisCount", "Uint32", 88],
];

/** What follows it: name, kind, which number of the header counts it, how many for each.
 * @type {[string, Float64ArrayConstructor | Float32ArrayConstructor | Uint8ArrayConstructor, string, number][]} */
export const BLOCKS = [
  ["trueValues", Float64Array, "valueCount", 1],
  ["measuredValues", Float64Array, "valueCount", 1],
  ["ages", Float64Array, "sensorCount", 1],
  ["trueRates", Float64Array, "jointCount", 1],
  ["measuredRates", Float64Array, "jointCount", 1],
  ["trueTwist", Float64Array, "", 3],
  ["estimatedTwist", Float64Array, "", 3],
  ["command", Float64Array, "channelCount", 1],
  ["believedParts", Float64Array, "partCount", 3],
  ["particles", Float64Array, "particleCount", 4],
  ["hypotheses", Float64Array, "hypothesisCount", 10],
  ["truePoses", Float32Array, "robotCount", 3],
  ["estimatedPoses", Float32Array, "robotCount", 3],
  ["covariances", Float32Array, "robotCount", 6],
  ["obstacles", Float32Array, "obstacleCount", 3],
  ["flags", Uint8Array, "robotCount", 1],
];

/**
 * A moment, of one robot all; `sensors` are its readings.
 * @typedef {object} Frame
 * @property {number} version
 * @property {number} number
 * @property {number} epoch
 * @property {number} time
 * @property {number} speed
 * @property {number} achieved
 * @property {number} tick
 * @property {number} newest
 * @property {number} states
 * @property {number} events
 * @property {number} robotCount
 * @property {number} obstacleCount
 * @property {number} selected
 * @property {number} valueCount
 * @property {number} sensorCount
 * @property {number} jointCount
 * @property {number} channelCount
 * @property {number} oldest
 * @property {number} partCount
 * @property {number} particleCount
 * @property {number} hypothesisCount
 * @property {Float64Array} trueValues
 * @property {Float64Array} measuredValues
 * @property {Float64Array} ages
 * @property {Float64Array} trueRates
 * @property {Float64Array} measuredRates
 * @property {Float64Array} trueTwist
 * @property {Float64Array} estimatedTwist
 * @property {Float64Array} command
 * @property {Float64Array} believedParts
 * @property {Float64Array} particles
 * @property {Float64Array} hypotheses
 * @property {Float32Array} truePoses
 * @property {Float32Array} estimatedPoses
 * @property {Float32Array} covariances
 * @property {Float32Array} obstacles
 * @property {Uint8Array} flags
 * @property {{true: Float64Array, measured: Float64Array, age: number}[]} sensors
 */

/** @typedef {"state" | "scene" | "parameters" | "history" | "events" | "manual" | "image" | "mapped" | "intended" | "folder" | "select" | "controls" | "run" | "pause" | "step" | "speed" | "reset" | "scrub" | "continue" | "go_back" | "futures" | "forget" | "replica" | "hand_over" | "drive" | "command" | "stop" | "set" | "restore" | "noises" | "add" | "remove" | "places" | "page" | "save_scenario" | "save_run" | "restart" | "reload"} CommandName */

/** @typedef {{"do": CommandName, [key: string]: unknown}} Command */

/**
 * A channel of a drive's command, or of a device that takes commands.
 * @typedef {object} Channel
 * @property {string} name
 * @property {string} unit
 * @property {number | null} low
 * @property {number | null} high
 */

/**
 * How readings are drawn; `style` is always there, and of the other keys those that the style needs.
 * @typedef {object} Drawing
 * @property {string} [style]
 * @property {number} [half_angle]
 * @property {number} [reach]
 * @property {number[]} [span]
 * @property {number[][][]} [lines]
 * @property {string[]} [colours]
 * @property {string[]} [names]
 */

/**
 * Things in the world other than walls and bodies; robots may know of them or not.
 * @typedef {object} Floor
 * @property {number[][]} landmarks
 * @property {number[][]} lights
 * @property {number[][][]} zones
 * @property {FloorPatch[]} patches
 */

/**
 * A line or an area on the floor, as `amorsim.core.patches.Patch`.
 * @typedef {object} FloorPatch
 * @property {number[][]} points
 * @property {number} width
 * @property {string} colour
 */

/**
 * A picture of a map; `name` is for the command ``image``. Occupied cells are black, free ones clear.
 * @typedef {object} Image
 * @property {string} name
 * @property {number[]} extent
 */

/**
 * The properties that robots of one kind share.
 * @typedef {object} Kind
 * @property {string} model
 * @property {string} drive
 * @property {Outline} footprint
 * @property {number[][]} wheels
 * @property {Channel[]} channels
 * @property {string[]} joints
 * @property {number[]} twist
 * @property {SensorShape[]} sensors
 * @property {string[]} estimators
 */

/**
 * The world as a robot knows it.
 * @typedef {object} Knowledge
 * @property {number | null} map
 * @property {number[][]} landmarks
 */

/**
 * A map to draw: lines, or a picture if it has none.
 * @typedef {object} MapShape
 * @property {string} name
 * @property {number[]} origin
 * @property {number[]} size
 * @property {number[]} extent
 * @property {number[][] | null} segments
 * @property {Image | null} image
 */

/**
 * An obstacle, or after all of those a part of a robot.
 * @typedef {object} ObstacleShape
 * @property {string} name
 * @property {Outline} footprint
 * @property {boolean} moves
 * @property {string} part_of
 * @property {string} colour
 */

/**
 * A footprint in its body's frame: a circle about the base point, or a polygon.
 * @typedef {object} Outline
 * @property {number} [circle]
 * @property {number[][]} [polygon]
 */

/**
 * A robot or an obstacle of which only the outline and the pose could be read.
 * @typedef {object} OutlineShape
 * @property {string} name
 * @property {Outline} footprint
 * @property {number[]} pose
 */

/**
 * The page's description of a recorded run.
 * @typedef {object} Recorded
 * @property {number} replica
 * @property {number[]} replicas
 * @property {string} log
 * @property {string[][]} facts
 * @property {string[]} lacks
 */

/**
 * A robot: `kind` is a place in the scene's `kinds`.
 * @typedef {object} RobotEntry
 * @property {string} name
 * @property {number} kind
 * @property {string} controller
 * @property {Knowledge} knowledge
 * @property {string} colour
 */

/**
 * Everything that does not change while a simulation runs. `map` and knowledge are places in `maps`.
 * @typedef {object} Scene
 * @property {number} version
 * @property {string} scenario
 * @property {number} dt
 * @property {number} duration
 * @property {number} seed
 * @property {MapShape[]} maps
 * @property {number | null} map
 * @property {Kind[]} kinds
 * @property {RobotEntry[]} robots
 * @property {ObstacleShape[]} obstacles
 * @property {Floor} floor
 * @property {Recorded} recorded
 */

/**
 * A sensor as it is drawn, by its nominal parameters; in an answer to ``parameters``, by its true ones.
 * @typedef {object} SensorShape
 * @property {string} name
 * @property {string} kind
 * @property {string} unit
 * @property {string[][]} columns
 * @property {number} size
 * @property {number[][]} mounts
 * @property {number[] | null} bearings
 * @property {number | null} range_max
 * @property {number | null} half_angle
 * @property {Drawing | null} drawing
 */

/**
 * A scenario at rest: what can be drawn of it without a simulation.
 * @typedef {object} Still
 * @property {Scene} scene
 * @property {(number[] | null)[]} robots
 * @property {(number[] | null)[]} obstacles
 * @property {OutlineShape[]} outlines
 * @property {number[]} extent
 */

/**
 * A chain of noise, in order; `group` is that of its fields. `gone` are elements that the scenario has in it.
 * @typedef {object} ChainForm
 * @property {string} path
 * @property {string} group
 * @property {ElementForm[]} elements
 * @property {string[]} gone
 */

/**
 * A parameter of a robot that was set while the simulation ran, and the value set last.
 * @typedef {object} ChangedParameter
 * @property {string} path
 * @property {any} value
 */

/**
 * An element of a chain: its name, its class's name, and whether it is not in the scenario.
 * @typedef {object} ElementForm
 * @property {string} name
 * @property {string} use
 * @property {string} path
 * @property {boolean} is_added
 */

/**
 * Something that happened; `number` counts from 1 within an epoch.
 * @typedef {object} EventLine
 * @property {number} number
 * @property {number} tick
 * @property {number} time
 * @property {string} kind
 * @property {string} robot
 * @property {string} text
 * @property {number[] | null} point
 * @property {string} stack
 * @property {boolean} is_told
 */

/**
 * A field of a form. `fixed` is the reason why its value cannot change now, and empty where it can.
 * @typedef {object} FieldForm
 * @property {string} path
 * @property {string} label
 * @property {string} help
 * @property {Widget} widget
 * @property {any} value
 * @property {any} default
 * @property {boolean} is_given
 * @property {boolean} is_required
 * @property {string} fixed
 */

/**
 * A course of events that was left by going on from its past: a robot's path in it, as in `History`.
 * @typedef {object} Future
 * @property {number} number
 * @property {number} since
 * @property {number} newest
 * @property {ChangedParameter[]} changes
 * @property {number[]} ticks
 * @property {number[][]} true
 * @property {number[][]} estimated
 * @property {Past} past
 */

/**
 * A robot's true and estimated path, and what else is known of its past.
 * @typedef {object} History
 * @property {boolean} ok
 * @property {number} epoch
 * @property {number[]} ticks
 * @property {((number | null)[])[]} true
 * @property {number[][]} estimated
 * @property {Past} past
 */

/**
 * The intentions of a controller in the last step; null where it has no such belief.
 * @typedef {object} Intended
 * @property {number[]} pose
 * @property {number[][] | null} path
 * @property {number[][] | null} searched
 * @property {IntendedArc[] | null} arcs
 * @property {boolean[] | null} blocked
 * @property {number[] | null} bearing
 * @property {number[][] | null} ways
 * @property {IntendedVelocities | null} velocities
 */

/**
 * A way that a controller compared: points in the world [m], from the robot on.
 * @typedef {object} IntendedArc
 * @property {number[][]} points
 * @property {number} worth
 * @property {boolean} taken
 */

/**
 * The bodies that a controller knows of, and the velocities that lead into them, in the robot's frame.
 * @typedef {object} IntendedVelocities
 * @property {number} speed
 * @property {number[]} twist
 * @property {number[][]} others
 * @property {number[][]} borders
 * @property {number[][]} cones
 */

/**
 * The map of an estimator, in the world [m]; parts that it has no belief of are missing.
 * @typedef {object} Mapped
 * @property {string} estimator
 * @property {MappedCells | null} map
 * @property {number[][] | null} scan
 * @property {number[][] | null} poses
 * @property {number[][] | null} edges
 */

/**
 * A picture of a map that an estimator has drawn: the more probable a wall, the more opaque.
 * @typedef {object} MappedCells
 * @property {number[]} extent
 * @property {string} png
 */

/**
 * A parameter of a part of a robot, as a form shows it while the simulation runs.
 * @typedef {object} ParameterForm
 * @property {string} path
 * @property {string} group
 * @property {string} part
 * @property {string} label
 * @property {string} unit
 * @property {string} help
 * @property {string} type
 * @property {Widget} widget
 * @property {number | null} low
 * @property {number | null} high
 * @property {boolean[]} is_open
 * @property {number[]} slider
 * @property {any} value
 * @property {any} scenario
 * @property {boolean} is_changed
 * @property {boolean} is_added
 * @property {string} fixed
 * @property {string} drawn
 * @property {number | null} drawn_value
 * @property {number | null} nominal
 * @property {number | null} true
 * @property {FieldForm[]} deviation
 * @property {string} kind
 * @property {string} origin
 * @property {string} source
 */

/**
 * The further values of a robot in plots: since it was first looked at, or since the start where robots are few.
 * @typedef {object} Past
 * @property {number[]} ticks
 * @property {string} values
 */

/**
 * The state of the simulation.
 * @typedef {object} State
 * @property {boolean} ok
 * @property {number} version
 * @property {number} epoch
 * @property {string} status
 * @property {number} tick
 * @property {number} newest
 * @property {number} time
 * @property {number | null} speed
 * @property {number} achieved
 * @property {number} selected
 * @property {string[]} by_hand
 * @property {boolean} can_continue
 * @property {string} reason
 * @property {EventLine | null} fault
 * @property {string} damage
 * @property {string} holder
 * @property {boolean} changed
 * @property {string} moved
 */

/**
 * A number in a list that has no error yet and may be given one.
 * @typedef {object} TargetForm
 * @property {string} path
 * @property {string} label
 */

/**
 * How a value is shown and changed.
 * @typedef {object} Widget
 * @property {string} kind
 * @property {boolean} is_optional
 * @property {string} unit
 * @property {number | null} low
 * @property {number | null} high
 * @property {boolean[]} is_open
 * @property {boolean} is_whole
 * @property {string[]} choices
 * @property {string} refers
 * @property {string} component
 * @property {string} frame
 * @property {Widget} item
 * @property {string[]} columns
 * @property {number | null} length
 * @property {FieldForm[]} fields
 * @property {Widget[]} options
 */

/**
 * A fault: its place, the value there, and what is wrong with it.
 * @typedef {object} FaultLine
 * @property {string} file
 * @property {number | null} line
 * @property {string} said
 * @property {string} path
 * @property {string} value
 * @property {string} message
 * @property {string} remedy
 */

/**
 * The state of a scenario's file: the answer to ``document``.
 * @typedef {object} FaultyFile
 * @property {boolean} ok
 * @property {number} number
 * @property {string} status
 * @property {string} file
 * @property {FaultLine[]} faults
 * @property {Still | null} still
 * @property {string} path
 */
