// The WebSocket: it never gives up, and says how it stands.

const WAIT_MS_MIN = 250;
const WAIT_MS_MAX = 2000;
/** After so many attempts in vain the server is called gone. */
const ATTEMPTS_PATIENT = 3;
/** A run that goes on and is not heard of for so long has a problem, and after the second a new connection is tried. */
const SILENT_MS = 2000;
const SILENT_MS_MAX = 10_000;

export class Connection {
  /** `handlers`: `message(object)`, `state(state, words)`. */
  constructor(handlers) {
    this.handlers = handlers;
    this.attempts = 0;
    this.state = "";
    this.goesOn = false;
    this.heardAt = performance.now();
    this.open();
    setInterval(() => this.watch(), 500);
  }

  get isOpen() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /** Whether it went out; what became of it, the server tells. */
  send(control) {
    if (!this.isOpen) return false;
    this.socket.send(JSON.stringify(control));
    return true;
  }

  /** Whether news are to be expected. */
  expect(goesOn) {
    this.goesOn = goesOn;
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const token = new URLSearchParams(location.search).get("token");
    const query = token === null ? "" : `?token=${encodeURIComponent(token)}`;
    const socket = new WebSocket(`${scheme}://${location.host}/live${query}`);
    this.socket = socket;
    socket.onopen = () => {
      this.attempts = 0;
      this.heardAt = performance.now();
      this.tell("connected", "connected");
    };
    socket.onmessage = (event) => {
      if (socket !== this.socket) return;
      this.heardAt = performance.now();
      if (this.state === "silent") this.tell("connected", "connected");
      this.handlers.message(JSON.parse(event.data));
    };
    socket.onclose = (event) => {
      if (socket === this.socket) this.again(event.code === 1001);
    };
  }

  again(saidGoodbye) {
    this.socket = null;
    this.attempts = saidGoodbye ? ATTEMPTS_PATIENT : this.attempts + 1;
    const gone = this.attempts >= ATTEMPTS_PATIENT;
    this.tell(gone ? "gone" : "reconnecting", gone ? "server gone, trying again" : "reconnecting");
    const wait = Math.min(WAIT_MS_MAX, WAIT_MS_MIN * 2 ** Math.min(this.attempts - 1, 8));
    setTimeout(() => this.open(), wait);
  }

  watch() {
    const silent = performance.now() - this.heardAt;
    if (!this.isOpen || !this.goesOn || silent < SILENT_MS) return;
    this.tell("silent", `no news for ${(silent / 1000).toFixed(0)} s`);
    if (silent > SILENT_MS_MAX) {
      const old = this.socket;
      this.again(false);
      old.close();
    }
  }

  tell(state, words) {
    this.state = state;
    this.handlers.state(state, words);
  }
}
