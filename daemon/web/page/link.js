// The connection to ovws-web: one stream to the browser, commands to the server, both with the token.

const token = () => location.hash.slice(1);
const headers = () => ({ Authorization: `Bearer ${token()}` });
const HEAD_BYTES = 8;
const MAX_LAG_MS = 2000;

/** Calls a method of the daemon. Resolves to {result} or {error: {message, data: {field, reason}}}; never rejects. */
export const call = (method, params = {}) => fetchJson("/rpc", { method, params });

/** Fetches a path, with POST if there is a `request`. Resolves as `call`. */
export async function fetchJson(path, request) {
  const failed = (message) => ({ error: { message, data: { field: "", reason: message } } });
  try {
    const sent = request ? { method: "POST", body: JSON.stringify(request) } : {};
    const reply = await fetch(path, { ...sent, headers: headers() });
    const body = await reply.json();
    if (!reply.ok) return failed(body.reason);
    if (body.error && !body.error.data) return failed(body.error.message);
    return body;
  } catch {
    return failed("ovws-web does not answer");
  }
}

/** The state of the commissioning; {reason} if it is refused, null if ovws-web does not answer. */
export async function commission() {
  try {
    const reply = await fetch("/commission", { headers: headers() });
    return reply.ok ? await reply.json() : { reason: (await reply.json()).reason };
  } catch {
    return null;
  }
}

/** An action of the commissioning; resolves as `call`. */
export const act = (action, step = "", offer = "") => fetchJson("/commission", { action, step, offer });

/** Fetches an image from the server as a blob; null if there is none. */
export async function picture(path) {
  try {
    const reply = await fetch(path, { headers: headers() });
    return reply.status === 200 ? await reply.blob() : null;
  } catch {
    return null;
  }
}

/** A part of the camera's newest image at full resolution as {json, binary}; null if there is none. */
export async function imagePart({ x, y, width, height }) {
  try {
    const reply = await fetch(`/image?x=${x}&y=${y}&width=${width}&height=${height}`, { headers: headers() });
    if (reply.status !== 200) return null;
    const inbox = new Inbox();
    inbox.add(new Uint8Array(await reply.arrayBuffer()));
    return inbox.next();
  } catch {
    return null;
  }
}

/** Splits the byte stream into messages. */
class Inbox {
  #parts = [];
  #size = 0;

  add(bytes) {
    this.#parts.push(bytes);
    this.#size += bytes.length;
  }

  #joined() {
    if (this.#parts.length > 1) {
      const all = new Uint8Array(this.#size);
      let at = 0;
      for (const part of this.#parts) {
        all.set(part, at);
        at += part.length;
      }
      this.#parts = [all];
    }
    return this.#parts[0];
  }

  /** The next complete message, or null. */
  next() {
    if (this.#size < HEAD_BYTES) return null;
    if (this.#parts[0].length < HEAD_BYTES) this.#joined();
    const head = new DataView(this.#parts[0].buffer, this.#parts[0].byteOffset);
    const jsonSize = head.getUint32(0, true);
    const size = HEAD_BYTES + jsonSize + head.getUint32(4, true);
    if (this.#size < size) return null;
    const all = this.#joined();
    const json = JSON.parse(new TextDecoder().decode(all.subarray(HEAD_BYTES, HEAD_BYTES + jsonSize)));
    const binary = all.slice(HEAD_BYTES + jsonSize, size).buffer;
    this.#parts = [all.subarray(size)];
    this.#size -= size;
    return { json, binary };
  }
}

let minLag = Infinity; // ms: clock difference plus transfer time

/** Whether this browser has fallen behind. It then reconnects, to skip stale messages that are still in transit. */
function isBehind(json) {
  if (json.schema !== "ovws.web.health/1") return false;
  const lag = Date.now() - json.t_ns / 1e6;
  minLag = Math.min(minLag, lag);
  return lag - minLag > MAX_LAG_MS;
}

async function readOnce(onMessage, onState) {
  minLag = Infinity; // a clock may have been set
  const reply = await fetch("/stream", { headers: headers(), cache: "no-store" });
  if (!reply.ok) {
    onState((await reply.json()).reason);
    return undefined;
  }
  onState("");
  const inbox = new Inbox();
  const reader = reply.body.getReader();
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return undefined;
    inbox.add(value);
    for (let message = inbox.next(); message; message = inbox.next()) {
      onMessage(message.json, message.binary);
      if (isBehind(message.json)) return reader.cancel();
    }
  }
}

/** Reads the stream forever and reconnects whenever it ends. onState: "" when connected, else the reason. */
export async function listen(onMessage, onState) {
  for (;;) {
    try {
      await readOnce(onMessage, onState);
    } catch {
      onState("No connection to ovws-web: reconnecting");
    }
    await new Promise((done) => setTimeout(done, 1000));
  }
}
