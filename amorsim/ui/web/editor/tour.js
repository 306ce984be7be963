// What the Editor's tour shows.

/** @type {import("../shared/tour.js").Step[]} */
export const TOUR = [
  { at: ".panel.toolbox", words: "Tools: select and move, walls, rooms, doors, a tape measure. Each has a key." },
  { at: ".bar [title*='robots, obstacles']", words: "Add a robot, an obstacle, people, furniture or a whole world, from a gallery with pictures (A)." },
  { at: ".pane", words: "The drawing. Drag things, their dots turn them, their corners resize them; the secondary button opens a menu; two fingers or the wheel zoom." },
  { at: ".panel.objects", words: "All that the scenario has, in a list. The eye hides a kind, the padlock locks it." },
  { at: ".panel.inspector", words: "What is selected, with all its values: drive, sensors, noise, estimators, controller, errors. ● is its own, ↳ is from its model." },
  { at: ".bar [title*='as text']", words: "The scenario's file beside the drawing. Each follows the other." },
  { at: ".status", words: "What is wrong, if anything is; a click on a fault leads to its place." },
  { at: ".bar .run", words: "Run it, saved or not. “← edit” leads back, and all is as it was." },
];
