// What the server is asked, and what it tells by itself.

/** A merge patch (RFC 7386). */
function merge(target, patch) {
  if (patch === null || typeof patch !== "object" || Array.isArray(patch)) return patch;
  const merged = { ...(target !== null && typeof target === "object" && !Array.isArray(target) ? target : {}) };
  for (const [key, value] of Object.entries(patch)) {
    if (value === null) delete merged[key];
    else merged[key] = merge(merged[key], value);
  }
  return merged;
}

async function get(path) {
  const answer = await fetch(path);
  return told(answer);
}

/** What the server says; a refusal is an error with its status. */
async function told(answer) {
  const value = await answer.json();
  if (!answer.ok) throw Object.assign(new Error(value.error ?? answer.statusText), { status: answer.status, said: value.said });
  return value;
}

async function post(path, body) {
  return told(await fetch(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) }));
}

/** Has a recording read; its file is sent as it is, and `about` says what is known of it. `sent` is told which part of it has gone, which is about what was read. */
export function diagnose(file, about, sent) {
  const request = new XMLHttpRequest();
  const done = new Promise((found, failed) => {
    request.addEventListener("load", () => {
      const { status, response } = request;
      if (status === 200 && response != null) found(response);
      else failed(Object.assign(new Error(response?.error ?? request.statusText), { status, said: response?.said }));
    });
    for (const [event, status] of [["error", 0], ["abort", null]]) request.addEventListener(event, () => failed(Object.assign(new Error(event), { status })));
  });
  request.upload.addEventListener("progress", ({ loaded, total }) => sent(loaded / total));
  request.open("POST", `/api/diagnose?${new URLSearchParams({ name: file.name, ...about })}`);
  request.setRequestHeader("Content-Type", "application/octet-stream");
  request.responseType = "json";
  request.send(file);
  return { done, cancel: () => request.abort() };
}

export const about = () => get("/api/about");
export const login = (token) => post("/api/login", { token });

export const sheet = (model) => get(`/api/sheet?model=${model}`);
export const units = () => get("/api/units");
export const history = (position, from) => get(`/api/history?position=${position}&from=${from}`);
export const happened = (from) => get(`/api/happened?from=${from}`);

/** Has a verb carried out; an answer that is no "ok" is an error. */
export const command = (verb) => post("/api/command", verb);

/** Tells each state of the ring, and whether there is a connection. */
export function follow(seen, connected) {
  const source = new EventSource("/api/events");
  let state = null;
  source.addEventListener("open", () => connected(true));
  source.addEventListener("error", () => connected(false));
  source.addEventListener("state", (event) => {
    state = JSON.parse(event.data);
    seen(state);
  });
  source.addEventListener("patch", (event) => {
    if (state === null) return;
    state = merge(state, JSON.parse(event.data));
    seen(state);
  });
}

/** Sends the newest of many values, one after the other, and drops those in between. */
export function newest(send) {
  let next = null;
  let busy = false;
  return async (value) => {
    next = { value };
    if (busy) return;
    busy = true;
    try {
      while (next) {
        const { value: now } = next;
        next = null;
        await send(now);
      }
    } finally {
      busy = false;
    }
  };
}
