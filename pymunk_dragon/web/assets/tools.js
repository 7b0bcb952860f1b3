// Tools of the pointer: drag bodies, cut joints, place obstacles, let go.

const JOINT_SLIP = 15; // pixels: largest distance of a click from the joint that it cuts
const BODY_SLIP = 12; // pixels: largest distance of a touch from the body that it takes
const MOUSE_SLIP = 3; // pixels: the same for a mouse
const GRAB_SLIP = 10; // pixels: the same for the server, where the body may have moved on
const MOST_NOTCHES = 100; // of the wheel, in a message
const DRAG_DIGITS = 6; // significant digits of where the hand is: inputs are kept in little memory
const MOST_DIGITS = 17; // those of a number, where the hand is far from the origin
const BUTTONS = [
  [1, 1],
  [4, 2],
  [2, 3],
]; // bits of `PointerEvent.buttons`, and pygame's numbers of the buttons
const TOOLS = ["drag", "cut", "round", "square", "release", "program"];
/** @type {Record<string, string>} */
const ABILITY_OF_TOOL = {
  program: "program",
  cut: "cut",
  round: "obstacles",
  square: "obstacles",
  release: "dancers",
};
// Sizes as parts of the field's shorter side.
const OBSTACLES = { low: 0.005, usual: 0.04, high: 0.25 };

class Tools {
  /** @param {Live} live */
  constructor(live) {
    this.live = live;
    this.chosen = "drag";
    this.sizes = scaleOf({ low: 1, high: 1 });
    /** @type {Numbers | null} */
    this.sent = null; // where the held body was last sent to
    /** @type {Point | null} */
    this.pointed = null; // where the program's pointer was moved to since the last picture
    /** @type {Point | null} */
    this.carried = null; // position of the pointer that holds a body
    /** @type {Point | null} */
    this.begun = null; // where a pointer is down that would hold a body when it moves
    this.slip = 0; // pixels: largest distance of that pointer from the body
    this.buttons = 0; // those that the program knows to be down, as in `PointerEvent.buttons`
    /** @type {Point | null} */
    this.place = null; // where the program's pointer is
    // Notches of the wheel, to the right and up, that the program was not sent yet.
    /** @type {Point | null} */
    this.turned = null;
  }

  // A rebuilt scene keeps the size of obstacles.
  /** @type {(model: Model, rebuilt: boolean) => void} */
  setModel(model, rebuilt) {
    this.drop();
    for (const tool of TOOLS) {
      const row = element(`tool-${tool}`).closest("label");
      row?.toggleAttribute("hidden", !model.can(ABILITY_OF_TOOL[tool]));
    }
    if (!model.can(ABILITY_OF_TOOL[this.chosen])) this.choose("drag");
    if (rebuilt) return;
    if (model.can("program")) this.choose("program");
    const side = Math.min(...model.field.size);
    this.sizes = scaleOf({
      low: OBSTACLES.low * side,
      high: OBSTACLES.high * side,
      logarithmic: true,
    });
    element("obstacle-size").value = String(this.sizes.positionOf(OBSTACLES.usual * side));
    this.showSize();
  }

  /** @type {(tool: string) => void} */
  choose(tool) {
    if (element(`tool-${tool}`).closest("label")?.hidden) return;
    this.drop();
    this.chosen = tool;
    element(`tool-${tool}`).checked = true;
    element("field").dataset.tool = tool;
    element("obstacle-row").hidden = !this.places;
    this.live.requestDraw();
  }

  // Whether the tool places obstacles.
  get places() {
    return this.chosen === "round" || this.chosen === "square";
  }

  get size() {
    return this.sizes.valueAt(element("obstacle-size").valueAsNumber);
  }

  showSize() {
    const text = this.live.model.lengthText(this.size);
    setText("obstacle-value", text);
    element("obstacle-size").setAttribute("aria-valuetext", text);
    this.live.requestDraw();
  }

  // ---- holding a body

  // What the hand takes within `slip` pixels of a pixel; null if nothing.
  /** @type {(pixel: Point, slip: number) => (Target & { point: Numbers }) | null} */
  bodyAt(pixel, slip) {
    const { view, moment } = this.live;
    return bodyAt(view.toWorld(...pixel), slip / view.scale, moment);
  }

  // Take hold of the body at a pixel; returns whether there is one.
  /** @type {(pixel: Point, kind: string) => boolean} */
  take(pixel, kind) {
    const { live } = this;
    if (this.isProgram) {
      this.carried = pixel;
      this.press(pixel, 1);
      return true;
    }
    if (!(this.chosen === "drag" || this.hearsClicks) || !live.controls) return false;
    this.slip = kind === "mouse" ? MOUSE_SLIP : BODY_SLIP;
    if (!this.bodyAt(pixel, this.slip)) return false;
    this.carried = this.begun = pixel;
    // A click does not touch the body.
    if (!this.hearsClicks) this.grab(pixel);
    return true;
  }

  // Hold the body at the pixel where the pointer went down or, if it has left, where it is now.
  /** @type {(now: Point) => void} */
  grab(now) {
    const { live, begun, slip } = this;
    const found = begun && (this.bodyAt(begun, slip) ?? this.bodyAt(now, slip));
    this.begun = null;
    if (!found) return;
    const [x, y] = found.point;
    // The body has moved on since the picture was made.
    live.send({ do: "grab", x, y, slip: Math.max(slip, GRAB_SLIP) / live.view.scale });
    this.sent = null;
    live.requestDraw();
  }

  /** @type {(pixel: Point) => void} */
  carry(pixel) {
    if (!this.carried) return;
    this.carried = pixel;
    if (this.isProgram) this.press(pixel, this.buttons);
    else if (this.begun) {
      const [x, y] = this.begun;
      if (Math.hypot(pixel[0] - x, pixel[1] - y) > TAP_SLIP) this.grab(pixel);
    }
    this.live.requestDraw();
  }

  drop() {
    if (this.place && this.buttons) this.press(this.place, 0);
    if (!this.carried) return;
    if (!(this.isPointer || this.begun)) this.live.send({ do: "drop" });
    this.carried = this.begun = null;
    this.live.requestDraw();
  }

  // Send where the held body is to go; once in each picture.
  flush() {
    this.flushProgram();
    if (!this.carried || this.isPointer || this.begun) return;
    const [x, y] = this.placeAt(this.carried);
    if (this.sent && this.sent[0] === x && this.sent[1] === y) return;
    this.sent = [x, y];
    this.live.send({ do: "drag", x, y });
  }

  // Where in the world a pixel is, to a tenth of a pixel at least.
  /** @type {(pixel: Point) => Numbers} */
  placeAt(pixel) {
    const { view } = this.live;
    return view.toWorld(...pixel).map((value) => {
      const digits = Math.ceil(Math.log10(Math.abs(value) * view.scale)) + 1;
      return Number(value.toPrecision(bounded(digits, DRAG_DIGITS, MOST_DIGITS)));
    });
  }

  // ---- pointer and wheel of a program

  // Whether the tool is the pointer of a pygame program.
  get isPointer() {
    return this.chosen === "program" && this.live.model.can("pointer");
  }

  // Whether they belong to the program now.
  get isProgram() {
    return this.isPointer && this.live.controls;
  }

  // Whether clicks do; the pointer then still drags bodies, or the view.
  get hearsClicks() {
    const { model, controls } = this.live;
    return this.chosen === "program" && controls && model.can("clicks");
  }

  // A button is clicked: 1 the left one or a finger, 2 the middle one, 3 the right one.
  /** @type {(pixel: Point, button: number) => void} */
  click(pixel, button) {
    if (!this.hearsClicks) return;
    const [x, y] = this.placeAt(pixel);
    this.live.send({ do: "click", x, y, button });
  }

  // The pointer is at a pixel with these buttons down. The program gets buttons at once,
  // and places in each picture.
  /** @type {(pixel: Point, buttons: number) => void} */
  press(pixel, buttons) {
    for (const [bit, button] of BUTTONS) {
      const down = (buttons & bit) > 0;
      if (down !== (this.buttons & bit) > 0) this.sendPointer(pixel, down ? "down" : "up", button);
    }
    this.buttons = buttons;
    this.place = this.pointed = pixel;
    this.live.requestDraw();
  }

  /** @type {(pixel: Point, kind: string, button: number) => void} */
  sendPointer(pixel, kind, button) {
    const [x, y] = this.placeAt(pixel);
    this.live.send({ do: "pointer", x, y, kind, button });
  }

  // The wheel is turned by notches to the right, and up.
  /** @type {(right: number, up: number) => void} */
  turn(right, up) {
    const [before, above] = this.turned ?? [0, 0];
    this.turned = [before + right, above + up];
    this.live.requestDraw();
  }

  flushProgram() {
    if (this.pointed) this.sendPointer(this.pointed, "move", 1);
    if (this.turned) {
      const [right, up] = this.turned.map((notches) =>
        bounded(notches, -MOST_NOTCHES, MOST_NOTCHES),
      );
      this.live.send({ do: "wheel", right, up });
    }
    this.pointed = this.turned = null;
  }

  // What the line of the hand joins: the server says where it holds the body.
  /** @returns {Held | null} */
  get held() {
    if (!this.live.frame.held) return null;
    const [x, y, ...target] = this.live.frame.held;
    return {
      anchor: [x, y],
      target: this.carried ? this.live.view.toWorld(...this.carried) : target,
    };
  }

  // ---- clicks

  // What a click at a pixel would change, with the tool that is chosen; null if nothing.
  /** @type {(pixel: Point, slip?: number) => Target | null} */
  targetAt(pixel, slip = 0) {
    const { view, moment, controls } = this.live;
    if (!controls) return null;
    const point = view.toWorld(...pixel);
    if (this.chosen === "drag") {
      return this.bodyAt(pixel, this.live.pixel ? MOUSE_SLIP : BODY_SLIP);
    }
    if (this.chosen === "cut") {
      const joint = jointAt(point, JOINT_SLIP / view.scale, moment.joints);
      return joint && { joint, point };
    }
    if (this.chosen === "release") {
      const bench = benchAt(moment.benches, point, slip / view.scale);
      return bench === null ? null : { bench };
    }
    return this.places ? this.obstacleAt(point, slip) : null;
  }

  /** @type {(point: Point, slip: number) => Target} */
  obstacleAt(point, slip) {
    const { state, view } = this.live;
    const standing = state.obstacles.find(
      (obstacle) => nearestOnShape(obstacleCall(obstacle), point).distance <= slip / view.scale,
    );
    if (standing) return { obstacle: standing, removes: true };
    return { obstacle: { shape: this.chosen, x: point[0], y: point[1], size: this.size } };
  }

  /** @type {(pixel: Point, kind: string) => void} */
  tap(pixel, kind) {
    this.click(pixel, 1);
    const target = this.chosen !== "drag" && this.targetAt(pixel, kind === "mouse" ? 0 : BODY_SLIP);
    const message = target && this.messageFor(target);
    if (message) this.live.send(message);
  }

  /** @type {(target: Target) => Message | null} */
  messageFor({ joint, point, bench, obstacle, removes }) {
    if (joint && point) {
      return { do: "cut", x: point[0], y: point[1], slip: JOINT_SLIP / this.live.view.scale };
    }
    // The head has no dancer of its own that could let go.
    if (bench !== undefined) return { do: "release", bench: Math.max(1, bench) };
    return removes ? { do: "remove", obstacle: obstacle?.id } : { do: "obstacle", ...obstacle };
  }

  // Keys apply the tool where the mouse is, or in the middle of the view.
  /** @returns {Point} */
  get aim() {
    const { view } = this.live;
    return this.live.pixel ?? [view.width / 2, view.height / 2];
  }

  // Apply the tool, for use with keys: a body is taken, and dropped by the next call.
  apply() {
    if (this.carried) this.drop();
    else if (this.chosen === "drag") this.take(this.aim, "touch");
    else this.tap(this.aim, "touch");
  }

  // What the mouse or the cross of the keys points at, with its name.
  /** @returns {Target | null} */
  get target() {
    if (this.carried || !(this.live.pixel || this.live.aims)) return null;
    const target = this.targetAt(this.aim, this.live.pixel ? 0 : BODY_SLIP);
    return target && { ...target, pixel: this.aim, label: this.labelOf(target) };
  }

  /** @type {(target: Target) => string} */
  labelOf({ joint, bench }) {
    const { errors } = this.live.frame;
    const force = joint && this.live.model.effortText(joint);
    if (joint) return localized("joint {i}: {force}", { i: joint.number, force });
    if (bench === undefined) return "";
    if (!(errors[bench] > 0)) return localized("bench {i}", { i: bench });
    return localized("bench {i}: error {error}", {
      i: bench,
      error: formatError(errors[bench], ERROR_KNOWN),
    });
  }
}
