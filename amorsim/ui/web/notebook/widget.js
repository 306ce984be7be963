// The Simulator's window in a notebook: its page in a frame of its own, and messages between that and the kernel.
//
// The page is not part of the notebook's: it has no address, no cookies, and reaches the kernel only by these messages.

const MOST_UNDRAWN = 2; // frames that the page was given and has not drawn

/** @typedef {{get(name: string): any, send(content: object): void, on(name: string, heard: Function): void, off(name: string, heard: Function): void}} Model */

/** @param {string} text base64 of gzip */
async function unpacked(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
}

/** Whether the notebook's own theme is dark; JupyterLab and VS Code say it in these ways. */
function isDark() {
  const { jpThemeLight, vscodeThemeKind } = document.body.dataset;
  if (jpThemeLight) return jpThemeLight === "false";
  if (vscodeThemeKind) return vscodeThemeKind.includes("dark");
  return matchMedia("(prefers-color-scheme: dark)").matches;
}

/** @param {{model: Model, el: HTMLElement}} given */
function render({ model, el }) {
  const view = Math.random().toString(36).slice(2);
  const frame = document.createElement("iframe");
  frame.sandbox.add("allow-scripts", "allow-downloads");
  frame.title = "amorsim: the Simulator";
  frame.style.cssText = `display: block; width: 100%; height: ${model.get("height")}px; border: 1px solid #8884; resize: vertical; overflow: auto;`;
  const tell = (/** @type {object} */ message, /** @type {Transferable[]} */ transfer = []) => frame.contentWindow?.postMessage(message, "*", transfer);

  // The kernel may send the next frame once this one is here; of those that the page has no time for, the newest waits.
  let [undrawn, waiting] = [0, /** @type {ArrayBuffer | null} */ (null)];
  const show = (/** @type {ArrayBuffer} */ buffer) => {
    if (undrawn >= MOST_UNDRAWN) waiting = buffer;
    else {
      undrawn++;
      tell({ frame: buffer }, [buffer]);
    }
  };

  const fromPage = (/** @type {MessageEvent} */ { source, data }) => {
    if (source !== frame.contentWindow || typeof data !== "object") return;
    if (data.drawn !== undefined) {
      undrawn = Math.max(0, undrawn - 1);
      const next = waiting;
      waiting = null;
      if (next) show(next);
      return;
    }
    if (data.is === "open") tell({ dark: isDark() });
    model.send({ ...data, window: view });
  };
  const fromKernel = (/** @type {any} */ message, /** @type {DataView[]} */ buffers) => {
    if (message.frame) {
      model.send({ is: "received", window: view });
      const { buffer, byteOffset, byteLength } = buffers[0];
      show(/** @type {ArrayBuffer} */ (buffer).slice(byteOffset, byteOffset + byteLength)); // a copy: other views get the same
    } else if (message.window === view) tell(message);
  };
  addEventListener("message", fromPage);
  model.on("msg:custom", fromKernel);
  unpacked(model.get("page")).then((page) => {
    frame.srcdoc = page;
  });
  el.append(frame);
  return () => {
    removeEventListener("message", fromPage);
    model.off("msg:custom", fromKernel);
    model.send({ is: "gone", window: view });
  };
}

export default { render };
