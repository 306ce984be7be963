// An editor of code with line numbers, colours and completion (CodeMirror); where it cannot be had, a plain text area.

import { h } from "../shared/dom.js";

const VENDOR = "amorsim/vendor/codemirror/codemirror.js";

/** @typedef {{text: string, help: string}} Choice */
/** What may stand at a place of a text: in its lines, at the end of the part of line number `line` that is before the cursor. `from` is
 * the column that it begins at.
 * @typedef {(lines: string[], line: number, before: string) => Promise<{from: number, choices: Choice[]} | null>} Choices */

/** @type {Promise<any> | null} */
let loading = null;

/** The editor of code, fetched once; null where it cannot be had. */
function codeMirror() {
  loading ??= import(VENDOR).catch(() => null);
  return loading;
}

/** How it looks. It is in a shadow tree, for there its styles are sheets of scripts, which the page's policy allows.
 * @param {any} code */
function looks({ EditorView, HighlightStyle, syntaxHighlighting, tags }) {
  const mono = 'ui-monospace, "DejaVu Sans Mono", monospace';
  const list = { border: "1px solid var(--line)", borderRadius: "7px", background: "var(--paper)", color: "var(--ink)", boxShadow: "0 8px 26px rgb(0 0 0 / 0.22)" };
  return [
    EditorView.theme({
      "&": { width: "100%", height: "100%", background: "var(--paper)", color: "var(--ink)" },
      "&.cm-focused": { outline: "none" },
      ".cm-scroller": { overflow: "auto", font: `13px/1.5 ${mono}` },
      ".cm-content": { caretColor: "var(--ink)" },
      ".cm-gutters": { borderColor: "var(--line)", background: "var(--ground)", color: "var(--soft)" },
      ".cm-matchingBracket": { background: "var(--pressed) !important" },
      ".code-fault": { background: "var(--danger-fill)" },
      ".code-fault-text": { padding: "0 6px 2px 30px", background: "var(--danger-fill)", color: "var(--danger)", font: "12px system-ui, sans-serif", whiteSpace: "pre-wrap" },
      ".cm-tooltip": list,
      ".cm-tooltip.cm-tooltip-autocomplete > ul": { maxWidth: "460px", maxHeight: "220px", fontFamily: mono },
      ".cm-tooltip-autocomplete > ul > li[aria-selected]": { background: "var(--pressed) !important", color: "inherit !important" },
      ".cm-completionDetail": { color: "var(--soft)", fontFamily: "system-ui, sans-serif", fontStyle: "normal" },
    }),
    syntaxHighlighting(HighlightStyle.define([
      { tag: [tags.keyword, tags.atom, tags.bool], color: "var(--estimated)" },
      { tag: tags.string, color: "var(--true)" },
      { tag: tags.comment, color: "var(--soft)" },
      { tag: tags.number, color: "var(--measured)" },
    ])),
  ];
}

/** Faults at their lines: what is added to an editor, and a function of the effect that shows them.
 * @param {any} code */
function faultLines({ Decoration, EditorView, StateEffect, StateField, WidgetType }) {
  class Words extends WidgetType {
    /** @param {string} words */
    constructor(words) {
      super();
      this.words = words;
    }

    /** @param {any} other */
    eq(other) {
      return other.words === this.words;
    }

    toDOM() {
      return h("div", { class: "code-fault-text" }, this.words);
    }
  }
  const change = StateEffect.define();
  const field = StateField.define({
    create: () => Decoration.none,
    update: (/** @type {any} */ marks, /** @type {any} */ transaction) => transaction.effects.reduce((/** @type {any} */ now, /** @type {any} */ effect) => (effect.is(change) ? effect.value : now), marks.map(transaction.changes)),
    provide: (/** @type {any} */ one) => EditorView.decorations.from(one),
  });
  return { field, show: (/** @type {any} */ doc, /** @type {{line: number, message: string}[]} */ faults) => change.of(Decoration.set(faults.filter(({ line }) => line <= doc.lines).flatMap(({ line, message }) => {
    const { from, to } = doc.line(line);
    return [Decoration.line({ class: "code-fault" }).range(from), Decoration.widget({ widget: new Words(message), block: true, side: 1 }).range(to)];
  }), true)) };
}

/** Completion as one types, from what may stand there.
 * @param {any} code
 * @param {Choices} choices */
const completing = ({ autocompletion }, choices) => autocompletion({
  icons: false,
  interactionDelay: 0,
  override: [async (/** @type {any} */ { state, pos, explicit }) => {
    const line = state.doc.lineAt(pos);
    const before = line.text.slice(0, pos - line.from);
    if (!explicit && !/[\w"]$/.test(before)) return null;
    const found = await choices(state.doc.toString().split("\n"), line.number - 1, before);
    return found && { from: line.from + found.from, validFor: /^"?[\w.-]*$/, options: found.choices.map(({ text, help }) => ({ label: text, detail: help })) };
  }],
});

/** Make a text area an editor of code: what is returned works on either.
 * @param {HTMLTextAreaElement} area
 * @param {"python" | "toml"} mode
 * @param {Choices | null} [choices] for completion */
export async function dress(area, mode, choices = null) {
  const code = await codeMirror();
  if (!code || !area.isConnected) {
    return {
      value: () => area.value, put: (/** @type {string} */ text) => (area.value = text), mark: () => {}, focus: () => area.focus(), end: () => {},
      changed: (/** @type {() => void} */ does) => area.addEventListener("input", does), left: (/** @type {() => void} */ does) => area.addEventListener("blur", does),
    };
  }
  const { acceptCompletion, bracketMatching, defaultKeymap, EditorState, EditorView, history, historyKeymap, indentUnit, indentWithTab, keymap, lineNumbers } = code;
  const host = h("div", { class: "code-editor" });
  const root = host.attachShadow({ mode: "open" });
  /** Called when the text has changed, and when it is left. @type {[(() => void)[], (() => void)[]]} */
  const [changed, left] = [[], []];
  const faults = faultLines(code);
  area.hidden = true;
  area.after(host);
  const view = new EditorView({
    doc: area.value, root, parent: root,
    extensions: [
      lineNumbers(), history(), bracketMatching(), indentUnit.of("    "), EditorState.readOnly.of(area.readOnly), faults.field, looks(code),
      mode === "python" ? code.python() : code.StreamLanguage.define(code.toml), choices ? completing(code, choices) : [],
      EditorView.contentAttributes.of({ "aria-label": area.getAttribute("aria-label") ?? "", tabindex: "0" }),
      keymap.of([
        { key: "Tab", run: acceptCompletion }, indentWithTab,
        { key: "Escape", run: (/** @type {any} */ one) => {
          one.contentDOM.blur();
          return true;
        } },
        ...historyKeymap, ...defaultKeymap,
      ]),
      EditorView.updateListener.of((/** @type {any} */ update) => {
        if (update.docChanged) area.value = view.state.doc.toString();
        if (update.docChanged) for (const does of changed) does();
        if (update.focusChanged && !view.hasFocus) for (const does of left) does();
      }),
    ],
  });
  return {
    value: () => view.state.doc.toString(),
    put: (/** @type {string} */ text) => view.dispatch({ changes: { from: 0, to: view.state.doc.length, insert: text } }),
    mark: (/** @type {{line: number, message: string}[]} */ found) => view.dispatch({ effects: faults.show(view.state.doc, found) }),
    changed: (/** @type {() => void} */ does) => changed.push(does),
    left: (/** @type {() => void} */ does) => left.push(does),
    focus: () => view.focus(),
    end: () => view.destroy(),
  };
}
