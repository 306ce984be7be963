// What maps are drawn with: their lines as paths, their pictures in the colours of the theme.

import { there } from "./dom.js";
import { tinted, wallPath } from "./world_marks.js";

/** @typedef {import("../simulator/messages.d.ts").MapShape} MapShape */

/** Where the picture of a map lies: another version of it lies there, too.
 * @param {MapShape} map */
const placeOf = ({ origin, image }) => [...origin, ...(image?.extent ?? [])].join();

export class Pictures {
  /** @param {() => void} changed called when a picture has come */
  constructor(changed) {
    this.changed = changed;
    this.version = 0; // rises whenever maps look otherwise
    /** @type {Map<MapShape, Path2D>} */
    this.paths = new Map();
    /** @type {Map<MapShape, {image: HTMLImageElement, shades: Map<string, import("./world_marks.js").Picture[]>}>} */
    this.images = new Map();
    /** Pictures of before, which are shown until the new ones have come. @type {Map<string, Map<string, import("./world_marks.js").Picture[]>>} */
    this.former = new Map();
  }

  /** Forget all: another scene, whose pictures are asked for by name.
   * @param {(name: string) => Promise<string | null>} pictureOf */
  reset(pictureOf) {
    this.paths.clear();
    for (const [map, { shades }] of this.images) if (shades.size) this.former.set(placeOf(map), shades);
    this.images.clear();
    this.pictureOf = pictureOf;
    this.version += 1;
  }

  /** A map's lines as one path, made once.
   * @param {MapShape} map */
  path(map) {
    if (!this.paths.has(map)) this.paths.set(map, wallPath(map));
    return this.paths.get(map);
  }

  /** A map's picture in a colour, loaded when first wanted; null until it is there, and where there are lines.
   * @param {MapShape} map
   * @param {string} colour */
  of(map, colour) {
    if (!map?.image || map.segments) return null;
    if (!this.images.has(map)) {
      const image = new Image();
      image.onload = () => {
        if (this.images.get(map)?.image !== image) return; // of a scene that is shown no more
        this.former.delete(placeOf(map));
        this.version += 1;
        this.changed();
      };
      this.images.set(map, { image, shades: new Map() });
      this.pictureOf?.(map.image.name).then((url) => url && (image.src = url));
    }
    const { image, shades } = there(this.images.get(map));
    if (!image.complete || !image.naturalWidth) return this.former.get(placeOf(map))?.get(colour) ?? null;
    if (!shades.has(colour)) shades.set(colour, tinted(image, colour));
    return shades.get(colour);
  }
}
