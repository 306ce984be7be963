// What maps are drawn with: their lines as paths, their pictures in the colours of the theme.

import { tinted, wallPath } from "./marks.js";

/** @typedef {import("../simulator/wire.js").MapShape} MapShape */

export class Pictures {
  /** @param {() => void} changed called when a picture has come */
  constructor(changed) {
    this.changed = changed;
    this.version = 0; // rises whenever maps look otherwise
    /** @type {Map<MapShape, Path2D>} */
    this.paths = new Map();
    /** @type {Map<MapShape, {image: HTMLImageElement, shades: Map<string, CanvasImageSource[]>}>} */
    this.images = new Map();
  }

  /** Forget all: another scene, whose pictures are asked for by name.
   * @param {(name: string) => Promise<string | null>} pictureOf */
  reset(pictureOf) {
    this.paths.clear();
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
        this.version += 1;
        this.changed();
      };
      this.images.set(map, { image, shades: new Map() });
      this.pictureOf?.(map.image.name).then((url) => url && (image.src = url));
    }
    const { image, shades } = this.images.get(map);
    if (!image.complete || !image.naturalWidth) return null;
    if (!shades.has(colour)) shades.set(colour, tinted(image, colour));
    return shades.get(colour);
  }
}
