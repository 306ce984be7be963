// A picture, a GIF and a video of the view: the panes as they are drawn, side by side.

import { context2d, there } from "./dom.js";

const MOST_FRAMES = 300;
const GIF_WIDTH = 900;
const VIDEO_WIDTH = 1920;
const VIDEO_BITS = 8e6; // a second
const VIDEO_EVERY = 40; // milliseconds

/** The kind of video that this browser can make: MP4 where it can, which every player and presentation shows. */
export const VIDEO = ["video/mp4;codecs=avc1.42E01F", "video/mp4", "video/webm"].find((kind) =>
  globalThis.MediaRecorder?.isTypeSupported(kind),
);

/** The panes that are shown, side by side on one canvas, at most so many pixels wide.
 * @param {HTMLCanvasElement[]} canvases
 * @param {import("./theme.js").Theme} theme */
export function compose(canvases, theme, widest = Infinity) {
  const shown = canvases.filter((canvas) => canvas.offsetParent !== null && canvas.width > 0);
  const gap = 8;
  const width = shown.reduce((sum, canvas) => sum + canvas.width, 0) + gap * (shown.length - 1);
  const height = Math.max(...shown.map((canvas) => canvas.height));
  const scale = Math.min(1, widest / width);
  const whole = document.createElement("canvas");
  whole.width = Math.round(width * scale);
  whole.height = Math.round(height * scale);
  const context = context2d(whole, { alpha: false });
  context.fillStyle = theme.line;
  context.fillRect(0, 0, whole.width, whole.height);
  let left = 0;
  for (const canvas of shown) {
    context.drawImage(canvas, left * scale, 0, canvas.width * scale, canvas.height * scale);
    left += canvas.width + gap;
  }
  return whole;
}

/** @returns {Promise<Blob>} */
const blobOf = (/** @type {HTMLCanvasElement} */ canvas) => new Promise((done) => canvas.toBlob((blob) => done(there(blob)), "image/png"));

/** @param {Blob} blob
 * @param {string} name */
export function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** @param {HTMLCanvasElement[]} canvases
 * @param {import("./theme.js").Theme} theme
 * @param {string} name */
export async function savePicture(canvases, theme, name) {
  download(await blobOf(compose(canvases, theme)), `${name}.png`);
}

/** Records the view every `every` milliseconds until it is stopped or full; the server makes a GIF of it. */
export class Film {
  /** @param {HTMLCanvasElement[]} canvases
   * @param {() => import("./theme.js").Theme} theme */
  constructor(canvases, theme, every = 100) {
    this.canvases = canvases;
    this.theme = theme;
    this.every = every;
    /** @type {Promise<Blob>[]} */
    this.frames = [];
    this.last = -Infinity;
  }

  get isFull() {
    return this.frames.length >= MOST_FRAMES;
  }

  /** Called after each drawing.
   * @param {number} now */
  look(now) {
    if (this.isFull || now - this.last < this.every - 5) return;
    this.last = now;
    this.frames.push(blobOf(compose(this.canvases, this.theme(), GIF_WIDTH)));
  }

  /** The GIF, as made by the server of the pictures: each is led by its length, four bytes, little endian. */
  async finish() {
    const parts = [];
    for (const picture of await Promise.all(this.frames)) {
      const length = new Uint8Array(4);
      new DataView(length.buffer).setUint32(0, picture.size, true);
      parts.push(length, picture);
    }
    const said = await fetch(`/amorsim/gif?every=${this.every}`, { method: "POST", body: new Blob(parts) });
    if (!said.ok) throw new Error(await said.text());
    return said.blob();
  }
}

/** Records the view as a video until it is stopped; the browser makes it as the view is drawn. */
export class Video {
  /**
   * @param {HTMLCanvasElement[]} canvases
   * @param {() => any} theme
   */
  constructor(canvases, theme) {
    this.canvases = canvases;
    this.theme = theme;
    this.last = -Infinity;
    /** @type {Blob[]} */
    this.frames = []; // parts of the file
    const first = compose(canvases, theme(), VIDEO_WIDTH);
    this.canvas = document.createElement("canvas");
    this.canvas.width = first.width - (first.width % 2); // H.264 needs even numbers of pixels
    this.canvas.height = first.height - (first.height % 2);
    this.recorder = new MediaRecorder(this.canvas.captureStream(), { mimeType: VIDEO, videoBitsPerSecond: VIDEO_BITS });
    this.recorder.addEventListener("dataavailable", ({ data }) => this.frames.push(data));
    this.recorder.start(1000);
  }

  /** Called after each drawing.
   * @param {number} now */
  look(now) {
    if (now - this.last < VIDEO_EVERY - 5) return;
    this.last = now;
    const view = compose(this.canvases, this.theme(), VIDEO_WIDTH);
    // A view that was made larger meanwhile is fitted in.
    const { width, height } = this.canvas;
    const scale = Math.min(width / view.width, height / view.height, 1);
    const context = context2d(this.canvas, { alpha: false });
    context.fillStyle = this.theme().line;
    context.fillRect(0, 0, width, height);
    context.drawImage(view, 0, 0, view.width * scale, view.height * scale);
  }

  /** The video. */
  async finish() {
    const stopped = new Promise((done) => this.recorder.addEventListener("stop", done));
    this.recorder.stop();
    await stopped;
    return new Blob(this.frames, { type: VIDEO });
  }
}
