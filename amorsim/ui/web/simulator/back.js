// The way back to the Editor, for a simulation that was started there.

/** Show a button where the page's address says which page of the Editor it came from.
 * @param {HTMLButtonElement} button */
export function leadBack(button) {
  const from = new URLSearchParams(location.search).get("from") ?? "";
  if (!/^\/edit\/[\w.-]+$/.test(from)) return; // an address may say anything
  button.hidden = false;
  button.addEventListener("click", () => location.assign(from));
}
