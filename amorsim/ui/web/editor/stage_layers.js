// The layers of the Editor's canvas, from the paper up: what stands still, then what is dragged or plays, then words and rulers.

import { StillRobotLayer, atRest } from "../shared/still.js";
import { BodiesLayer, NamesLayer } from "../shared/world.js";
import { Carried } from "./carried.js";
import { GhostsLayer } from "./ghosts.js";
import { MarksLayer, PreviewLayer, WordsLayer } from "./layers.js";
import { RulersLayer } from "./rulers.js";
import { PlacesLayer, ViewsLayer } from "./views.js";

/** Put the Editor's own layers among those that every drawing has.
 * @param {import("./stage.js").EditStage} stage */
export function arrangeLayers(stage) {
  const { layers } = stage.pane;
  layers.unshift(stage.underlay);
  const bodies = layers.findIndex((layer) => layer instanceof BodiesLayer);
  layers.splice(bodies, 0, atRest(new ViewsLayer(stage, false)), atRest(new PlacesLayer(stage, false)), atRest(new GhostsLayer(stage)));
  const above = new Carried(stage);
  layers.push(
    atRest(new MarksLayer(stage, false)),
    new ViewsLayer(stage, true), new PlacesLayer(stage, true), new BodiesLayer(above), new StillRobotLayer(above), new NamesLayer(above, "true"), new MarksLayer(stage, true),
    new PreviewLayer(stage), new WordsLayer(stage), new RulersLayer(() => stage.options.grid && stage.still !== undefined),
  );
}
