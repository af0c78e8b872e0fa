// The part of a time axis that is shown, and how it is chosen: by wheel, by dragging, by fingers and by keys.

/** The shortest part: two frames. */
const SHORTEST = 0.1e9;
const STEP = 1.5;
/** So far is pressed and not dragged, in pixels. */
const STILL = 5;

/** The part of what `kept()` has, from its first to its last time; it follows the newest until it is held or moved. */
export function part_of(kept, usual) {
  const part = { span: usual, end: null };
  const clamp = () => {
    const { first, last } = kept();
    part.span = Math.min(Math.max(part.span, SHORTEST), Math.max(last - first, usual));
    if (part.end != null) part.end = Math.max(Math.min(part.end, last), Math.min(first + part.span, last));
  };
  part.range = () => {
    const end = part.end ?? kept().last;
    return { begin: end - part.span, end };
  };
  part.hold = () => { part.end ??= kept().last; };
  part.follow = () => { part.end = null; };
  /** Shows from one time to another. */
  part.show = (begin, end) => {
    part.span = end - begin;
    part.end = end;
    clamp();
  };
  /** Makes the part so many times as long; the time `at` stays where it is. Who follows the newest goes on following. */
  part.scale = (factor, at) => {
    const { end } = part.range();
    if (part.end == null && at == null) {
      part.span *= factor;
      return clamp();
    }
    const fixed = at ?? end - part.span / 2;
    const to = fixed + (end - fixed) * factor;
    part.show(to - part.span * factor, to);
  };
  /** Moves it by a part of itself. */
  part.move = (by) => {
    part.end = part.range().end + by * part.span;
    clamp();
  };
  part.reset = () => {
    part.span = usual;
    part.end = null;
  };
  return part;
}

/** What each key does. */
const KEYS = {
  "+": (part) => part.scale(1 / STEP),
  "=": (part) => part.scale(1 / STEP),
  "-": (part) => part.scale(STEP),
  ArrowLeft: (part) => part.move(-0.1),
  ArrowRight: (part) => part.move(0.1),
  PageUp: (part) => part.move(-0.9),
  PageDown: (part) => part.move(0.9),
  Home: (part) => part.move(-Infinity),
  End: (part) => part.follow(),
  0: (part) => part.reset(),
  Escape: (part) => part.reset(),
};

export const closer = (part) => part.scale(1 / STEP);
export const farther = (part) => part.scale(STEP);

/** Has the part chosen on a canvas. `changed` is told of what is chosen, and of the range that is being dragged. */
export function chosen_on(canvas, part, changed) {
  const fingers = new Map();
  let from = null;
  const across = (event) => {
    const box = canvas.getBoundingClientRect();
    return Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1);
  };
  const time = (share) => { const { begin, end } = part.range(); return begin + share * (end - begin); };
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) part.move(Math.sign(event.deltaX || event.deltaY) * 0.1);
    else part.scale(event.deltaY < 0 ? 1 / STEP : STEP, part.end == null && across(event) > 0.95 ? null : time(across(event)));
    changed(null);
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, across(event));
    // A range that is chosen does not run away.
    if (fingers.size === 1) from = { share: across(event), x: event.clientX, held: part.end == null };
    part.hold();
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    const now = across(event);
    if (before == null) return changed(null, now);
    fingers.set(event.pointerId, now);
    if (fingers.size === 2) pinch(event.pointerId, before, now);
    else if (event.pointerType === "touch" || event.shiftKey) part.move(before - now);
    else return changed([Math.min(from.share, now), Math.max(from.share, now)], now);
    changed(null);
  });
  /** What is under two fingers stays under them. */
  const pinch = (id, before, now) => {
    const [other] = [...fingers].filter(([finger]) => finger !== id).map(([, share]) => share);
    const [was, is] = [Math.abs(before - other), Math.abs(now - other)];
    if (was > 0.01 && is > 0.01) part.scale(was / is, time(other));
  };
  const drop = (event) => {
    if (!fingers.delete(event.pointerId) || fingers.size > 0) return;
    const dragged = event.type === "pointerup" && Math.abs(event.clientX - from.x) > STILL;
    if (dragged && event.pointerType !== "touch" && !event.shiftKey) {
      const [begin, end] = [from.share, across(event)].sort((a, b) => a - b).map(time);
      part.show(begin, end);
    } else if (!dragged && from.held) part.follow();
    changed(null);
  };
  canvas.addEventListener("pointerup", drop);
  canvas.addEventListener("pointercancel", drop);
  canvas.addEventListener("pointerleave", () => changed(null));
  canvas.addEventListener("dblclick", () => { part.reset(); changed(null); });
  canvas.addEventListener("keydown", (event) => {
    const does = event.ctrlKey || event.altKey || event.metaKey ? null : KEYS[event.key];
    if (!does) return;
    event.preventDefault();
    does(part);
    changed(null);
  });
}
