// The connection to the server: calls with answers, and events. See cprm_gym/studio/__init__.py for the messages.

/** One websocket that is opened again when it is lost. */
export class Connection {
  constructor(token) {
    this.token = token;
    this.number = 0;
    this.waiting = new Map();
    this.listeners = new Map();
    this.state = "connecting";
    this.open();
  }

  open() {
    const address = new URL("ws", document.baseURI);
    address.protocol = "ws:";
    address.search = `?token=${encodeURIComponent(this.token)}`;
    this.socket = new WebSocket(address);
    this.socket.onopen = () => this.become("open");
    this.socket.onmessage = (message) => this.receive(JSON.parse(message.data));
    this.socket.onclose = () => {
      for (const { refuse } of this.waiting.values()) refuse(new Refused("the connection is lost", "Connection"));
      this.waiting.clear();
      this.become("lost");
      setTimeout(() => this.open(), 1000);
    };
  }

  become(state) {
    if (state === this.state) return;
    this.state = state;
    this.tell({ event: "connection", state });
  }

  receive(message) {
    if (!("re" in message)) return this.tell(message);
    const call = this.waiting.get(message.re);
    this.waiting.delete(message.re);
    if (!call) return undefined;
    return "error" in message ? call.refuse(new Refused(message.error, message.kind)) : call.accept(message.result);
  }

  tell(message) {
    for (const listener of this.listeners.get(message.event) ?? []) listener(message);
  }

  /** Ask the server: `await call("watch.step", {cycles: 1})`. Refused with what is wrong. */
  call(name, given = {}) {
    if (this.socket.readyState !== WebSocket.OPEN) return Promise.reject(new Refused("the connection is lost", "Connection"));
    const id = ++this.number;
    return new Promise((accept, refuse) => {
      this.waiting.set(id, { accept, refuse });
      this.socket.send(JSON.stringify({ id, call: name, with: given }));
    });
  }

  /** Be told of an event; returns what ends it. */
  on(event, listener) {
    if (!this.listeners.has(event)) this.listeners.set(event, new Set());
    this.listeners.get(event).add(listener);
    return () => this.listeners.get(event).delete(listener);
  }
}

/** What a call answers when it is refused; `kind` is the name of the error in Python. */
export class Refused extends Error {
  constructor(message, kind) {
    super(message);
    this.kind = kind;
  }
}
