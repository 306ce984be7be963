// A picture and a moving picture of the view: the panes as they are drawn, side by side.

const MOST_FRAMES = 300;
const GIF_WIDTH = 900;

/** The panes that are shown, side by side on one canvas, at most so many pixels wide. */
export function compose(canvases, theme, widest = Infinity) {
  const shown = canvases.filter((canvas) => canvas.offsetParent !== null && canvas.width > 0);
  const gap = 8;
  const width = shown.reduce((sum, canvas) => sum + canvas.width, 0) + gap * (shown.length - 1);
  const height = Math.max(...shown.map((canvas) => canvas.height));
  const scale = Math.min(1, widest / width);
  const whole = document.createElement("canvas");
  whole.width = Math.round(width * scale);
  whole.height = Math.round(height * scale);
  const context = whole.getContext("2d", { alpha: false });
  context.fillStyle = theme.line;
  context.fillRect(0, 0, whole.width, whole.height);
  let left = 0;
  for (const canvas of shown) {
    context.drawImage(canvas, left * scale, 0, canvas.width * scale, canvas.height * scale);
    left += canvas.width + gap;
  }
  return whole;
}

const blobOf = (canvas) => new Promise((done) => canvas.toBlob(done, "image/png"));

export function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

export async function savePicture(canvases, theme, name) {
  download(await blobOf(compose(canvases, theme)), `${name}.png`);
}

/** Records the view every `every` milliseconds until it is stopped or full; the server makes a GIF of it. */
export class Film {
  constructor(canvases, theme, every = 100) {
    this.canvases = canvases;
    this.theme = theme;
    this.every = every;
    this.frames = [];
    this.last = -Infinity;
  }

  get isFull() {
    return this.frames.length >= MOST_FRAMES;
  }

  /** Called after each drawing. */
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
