// The one connection of a window: frames come as bytes, answers and news as text. A frame is acknowledged once it is
// drawn, and the server sends none before: so a slow window gets fewer frames, always the newest.

/** What tells this tab from others, also after its page is loaded again: the controls wait for it. */
function ownTab() {
  const fresh = () => Math.random().toString(36).slice(2);
  try {
    return (sessionStorage["amorsim.tab"] ??= fresh() + fresh());
  } catch {
    return ""; // nothing may be stored
  }
}

const SOON = 4; // attempts to connect again, within some seconds

/** What is said when a connection is lost: in the end, what to do.
 * @param {number} attempts that were made to connect again
 * @param {string} [kept] what is not lost */
export function lostWords(attempts, kept = "") {
  const words = attempts < SOON ? "The connection to amorsim is lost; trying again." : "amorsim does not answer. If it has ended, give its command again in the terminal, and open the address that it prints.";
  return kept ? `${words} ${kept}` : words;
}

/**
 * What a window does with what it hears.
 * @typedef {{frame: (buffer: ArrayBuffer) => void, news: (message: any) => void, open: () => void, lost: (attempts: number) => void}} Heard
 */

export class Connection {
  /** @param {Heard} on
   * @param {string} page whose session it talks with */
  constructor(on, page = location.pathname) {
    this.on = on;
    this.page = page;
    this.isEnded = false;
    this.waiting = new Map();
    this.next = 1;
    this.delay = 300;
    this.attempts = 0; // to connect again
    this.tab = ownTab();
    this.connect();
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.socket = new WebSocket(`${scheme}://${location.host}/amorsim/socket${this.page}?tab=${this.tab}`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => {
      this.delay = 300;
      this.attempts = 0;
      this.on.open();
    };
    this.socket.onmessage = ({ data }) => {
      if (typeof data !== "string") {
        this.on.frame(data);
        return;
      }
      const message = JSON.parse(data);
      if (message.answer === undefined) {
        this.on.news(message);
        return;
      }
      this.waiting.get(message.answer)?.(message.said);
      this.waiting.delete(message.answer);
    };
    this.socket.onclose = () => {
      for (const answer of this.waiting.values()) answer({ ok: false, error: "The connection is lost." });
      this.waiting.clear();
      if (this.isEnded) return;
      this.on.lost(this.attempts++);
      setTimeout(() => this.connect(), this.delay);
      this.delay = Math.min(this.delay * 2, 5000);
    };
  }

  /** End it for good. */
  close() {
    this.isEnded = true;
    this.socket?.close();
  }

  get isOpen() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /** Say a command; a promise of its answer, which always comes, `ok` false with an `error` where it failed.
   * @param {object} command */
  ask(command) {
    if (!this.isOpen) return Promise.resolve({ ok: false, error: "The connection is lost." });
    const id = this.next++;
    return new Promise((answer) => {
      this.waiting.set(id, answer);
      this.socket?.send(JSON.stringify({ id, ...command }));
    });
  }

  /** The frame of this number is drawn: the next may come.
   * @param {number} number */
  drawn(number) {
    if (this.isOpen) this.socket?.send(JSON.stringify({ drawn: number }));
  }
}
