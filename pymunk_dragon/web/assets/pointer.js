// Mouse, pen and touch on the canvas: drag to pan, pinch or use the wheel to zoom, tap to select.

const TAP_SLIP = 6; // pixels: largest movement during a tap
const WHEEL_ZOOM = 0.0016; // exponent of the zoom per pixel of the wheel
const WHEEL_LINE = 16; // pixels: a line of wheels that count lines

// Position of an event on the canvas.
/** @type {(canvas: HTMLElement, event: MouseEvent) => Point} */
function pixelOf(canvas, { clientX, clientY }) {
  const { left, top } = canvas.getBoundingClientRect();
  return [clientX - left, clientY - top];
}

// `taken` returns whether a pointer that goes down takes hold of something; its movements are then
// `carried` instead of panning the view, until it is `dropped`. One that has not moved is also
// `tapped`.
/** @type {(canvas: HTMLCanvasElement, view: Zoomed, pointers: Pointers) => void} */
function listenToPointers(
  canvas,
  view,
  { moved, hovered, tapped, taken = () => false, carried = () => {}, dropped = () => {} },
) {
  /** @type {Map<number, { start: Point, now: Point }>} */
  const down = new Map();
  let slipped = false;
  let holds = false;
  const drop = () => {
    if (holds) dropped();
    holds = false;
  };
  /** @type {(event: MouseEvent) => Point} */
  const position = (event) => pixelOf(canvas, event);
  /** @type {(two: Point[]) => number} */
  const spread = ([a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]);
  /** @type {(two: Point[]) => Point} */
  const middle = ([a, b]) => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];

  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    canvas.setPointerCapture(event.pointerId);
    slipped = down.size > 0;
    down.set(event.pointerId, { start: position(event), now: position(event) });
    if (slipped) drop();
    else holds = taken(position(event), event.pointerType);
  });
  canvas.addEventListener("pointermove", (event) => {
    const here = position(event);
    const pointer = down.get(event.pointerId);
    if (!pointer) {
      if (event.pointerType === "mouse") hovered(here);
      return;
    }
    const before = [...down.values()].map(({ now }) => now);
    const last = pointer.now;
    pointer.now = here;
    if (holds) {
      slipped ||= spread([pointer.start, here]) > TAP_SLIP;
      carried(here);
    } else if (down.size === 1) {
      if (!slipped && spread([pointer.start, here]) <= TAP_SLIP) {
        pointer.now = last;
        return;
      }
      slipped = true;
      view.pan(here[0] - last[0], here[1] - last[1]);
      moved("pan");
    } else if (down.size === 2) {
      const after = [...down.values()].map(({ now }) => now);
      const from = middle(before);
      const to = middle(after);
      view.zoom(spread(after) / Math.max(1, spread(before)), ...from);
      view.pan(to[0] - from[0], to[1] - from[1]);
      moved("pinch");
    }
  });
  /** @type {(event: PointerEvent) => void} */
  const up = (event) => {
    const tap = down.delete(event.pointerId) && !slipped && event.type === "pointerup";
    drop();
    if (tap) tapped(position(event), event.pointerType);
  };
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("pointerleave", () => hovered(null));
  listenToWheel(canvas, view, moved);
}

/** @type {(canvas: HTMLElement, view: Zoomed, moved: (how: string) => void) => void} */
function listenToWheel(canvas, view, moved) {
  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const delta = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? WHEEL_LINE : 1);
      // Browsers report pinching on a touchpad as wheel events with Ctrl, in small steps.
      view.zoom(Math.exp(-delta * WHEEL_ZOOM * (event.ctrlKey ? 5 : 1)), ...pixelOf(canvas, event));
      moved("zoom");
    },
    { passive: false },
  );
}
