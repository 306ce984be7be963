// What the Simulator's tour shows.

/** @type {import("../shared/tour.js").Step[]} */
export const TOUR = [
  { at: ".panel.robot", words: "The world as it is: the robot at its true pose, with its true readings. Drag moves the view, the wheel zooms." },
  { at: ".panel.control", words: "What the robot knows and nothing more: its estimated pose, with what it measured drawn from there, over its own map." },
  { at: "#run", words: "Run and pause, also by Space. Next to it one step, and the speed." },
  { at: ".panel.errors", words: "The robot's errors: what is true against what its software believes. Move a slider while it runs, and watch the right pane. M lets you drive by hand." },
  { at: ".panel.numbers", words: "Each quantity as true, measured and estimated, with the difference. A click on a row plots it, with Shift in a plot of its own." },
  { at: ".panel.plot", words: "Over time. Drag along it to zoom; + adds a plot, ⤓ saves one." },
  { at: ".timeline", words: "Go back to any moment. From there, “continue here” begins another future; the one that was left stays beside it." },
  { at: ".panel.events", words: "What happened, newest first. A click goes to its moment and place." },
  { at: ".bar .menu", words: "Keep it, under “save”: the run as a folder, the scenario with its present values, the run as a page for anybody. “lecture” makes all of it large." },
];
