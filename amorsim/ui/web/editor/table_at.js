// Where in a text of TOML a line is: which table it belongs to, and what has been written of that already.

const HEADER = /^\s*(\[\[?)\s*([^\]]+?)\s*\]\]?/;
const KEY = /^\s*([A-Za-z0-9_-]+)\s*=/;

/**
 * The table of a line, as the path of its values: "robots.1.sensors.laser" in the second of `[[robots]]`; empty above the
 * first header. And the keys that the table has by then and after.
 * @param {string[]} lines
 * @param {number} line from 0
 * @returns {{path: string, keys: Set<string>}}
 */
export function tableAt(lines, line) {
  /** How many items each list of tables has so far, by its path. @type {Map<string, number>} */
  const counts = new Map();
  let path = "";
  let keys = new Set();
  for (let n = 0; n < lines.length; n++) {
    const header = lines[n].match(HEADER);
    if (header) {
      if (n > line) break;
      path = pathOf(header[2].split(".").map((part) => part.trim().replace(/^["']|["']$/g, "")), header[1] === "[[", counts);
      keys = new Set();
      continue;
    }
    const key = n === line ? null : lines[n].match(KEY);
    if (key) keys.add(key[1]);
  }
  return { path, keys };
}

/** @param {string[]} parts
 * @param {boolean} isItem whether it begins one more item of a list
 * @param {Map<string, number>} counts */
function pathOf(parts, isItem, counts) {
  let path = "";
  parts.forEach((part, n) => {
    path = path ? `${path}.${part}` : part;
    const isLast = n === parts.length - 1;
    if (isItem && isLast) counts.set(path, (counts.get(path) ?? -1) + 1);
    if (counts.has(path) && (isItem || !isLast)) path = `${path}.${counts.get(path)}`;
  });
  return path;
}
