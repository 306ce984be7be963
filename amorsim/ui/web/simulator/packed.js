// The run in a page, unpacked: what `amorsim/ui/run_page` packs.

const NOT_A_NUMBER = -(2 ** 31);
const SPECIAL = new Map([[NOT_A_NUMBER, NaN], [2 ** 31 - 1, Infinity], [NOT_A_NUMBER + 1, -Infinity]]);

/** @typedef {{at: number, rows: number, width: number, exponents: number[]}} Series */

/** A table of numbers; rows are made when they are asked for. */
export class Table {
  /**
   * @param {Uint8Array} bytes
   * @param {Series} series
   */
  constructor(bytes, { at, rows, width, exponents }) {
    this.rows = rows;
    this.width = width;
    this.exponents = exponents;
    const count = rows * width;
    this.whole = new Int32Array(count); // column by column
    for (let place = 0, n = 0; n < width; n++) {
      let sum = 0;
      for (let row = 0; row < rows; row++, place++) {
        let folded = 0;
        for (let plane = 3; plane >= 0; plane--) folded = (folded << 8) | bytes[at + plane * count + place];
        sum = (sum + ((folded >>> 1) ^ -(folded & 1))) | 0;
        this.whole[place] = sum;
      }
    }
  }

  /** @param {number} row */
  row(row) {
    const numbers = new Float64Array(this.width);
    for (let n = 0; n < this.width; n++) {
      const whole = this.whole[n * this.rows + row];
      const special = SPECIAL.get(whole);
      // A negative power of ten is divided by: 12 / 10 is 1.2, and 12 * 0.1 is not.
      const power = this.exponents[n];
      numbers[n] = special ?? (power < 0 ? whole / 10 ** -power : whole * 10 ** power);
    }
    return numbers;
  }

  /** Rows side by side in one array.
   * @param {number} from
   * @param {number} to */
  flat(from = 0, to = this.rows) {
    const numbers = new Float64Array((to - from) * this.width);
    for (let row = from; row < to; row++) numbers.set(this.row(row), (row - from) * this.width);
    return numbers;
  }
}

/** The contents of a page: the text's table, and the bytes that its series are in.
 * @param {string} text base64 of gzip
 * @returns {Promise<{head: any, bytes: Uint8Array}>} */
export async function unpack(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const buffer = await new Response(stream).arrayBuffer();
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  return { head, bytes: new Uint8Array(buffer, 4 + length) };
}
