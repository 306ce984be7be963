// What the browser keeps for this page; where nothing may be stored, as in a notebook, the page keeps it for itself.

/** @type {Map<string, string>} */
const own = new Map();

/** @param {string} key
 * @returns {string | null} */
export function kept(key) {
  try {
    return localStorage.getItem(key);
  } catch {
    return own.get(key) ?? null;
  }
}

/** @param {string} key
 * @param {string | null} value null forgets it */
export function keep(key, value) {
  if (value === null) own.delete(key);
  else own.set(key, value);
  try {
    if (value === null) localStorage.removeItem(key);
    else localStorage.setItem(key, value);
  } catch {
    // It holds for this page alone.
  }
}
