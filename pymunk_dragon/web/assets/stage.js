// The canvas of the player and of the live page: what is in view, what is shown on it,
// and the controls that both have.

const PAN_STEP = 1 / 8; // fraction of its size by which the view moves
const ZOOM_STEP = 1.4; // times
const REPEATED = /^(arrow.*|[-+=wasd])$/; // keys that act again while they are held
const MODIFIERS = /^(control|meta|alt)$/;

// Pages add `tick`, which draws, `afterChange`, which is called after a change, and `playing`.
/** @template {Picture} [P=any] */
class Stage extends Surface {
  /**
   * @param {DrawnModel} model
   * @param {Layer<P>[]} layers
   * @param {string[]} switches
   * @param {string[]} shown
   */
  constructor(model, layers, switches, shown) {
    super(element("field"));
    this.view = new View(model);
    this.painter = new Painter(this, this.view, model, layers);
    /** @type {string | null} */
    this.follow = "field"; // or "head", also of what a program follows, or null for a fixed view
    /** @type {Record<string, boolean>} */
    this.shown = Object.fromEntries(switches.map((name) => [name, shown.includes(name)]));
    /** @type {Point | null} */
    this.pixel = null; // position of the mouse
  }

  resize() {
    super.resize();
    this.view.width = this.width;
    this.view.height = this.height;
  }

  // Before drawing: what the view follows, and where that is.
  /** @type {(point: Point | null | undefined) => void} */
  followSubject(point) {
    if (this.follow === "field") this.view.fit();
    if (this.follow === "head" && point) [this.view.x, this.view.y] = point;
  }

  /** @type {(subject: string | null) => void} */
  setFollow(subject) {
    this.follow = subject;
    // A closer view stays as it is.
    if (subject === "head") this.view.span = Math.min(this.view.span, this.view.headSpan);
    this.afterChange();
  }

  /** @type {(factor: number) => void} */
  zoom(factor) {
    this.view.zoom(factor);
    if (this.follow === "field") this.follow = null;
    this.afterChange();
  }

  /** @type {(right: number, down: number) => void} */
  pan(right, down) {
    this.view.pan(-right * PAN_STEP * this.view.width, -down * PAN_STEP * this.view.height);
    this.viewMoved("pan");
  }

  // The user has moved the view, which then follows nothing,
  // but zooming while playing keeps the head centred.
  /** @type {(how: string) => void} */
  viewMoved(how) {
    if (!(how === "zoom" && this.playing && this.follow === "head")) this.follow = null;
    this.afterChange();
  }

  showView() {
    element("fit").setAttribute("aria-pressed", String(this.follow === "field"));
    element("follow").setAttribute("aria-pressed", String(this.follow === "head"));
    for (const [name, shown] of Object.entries(this.shown)) element(`show-${name}`).checked = shown;
  }
}

// Hide the switch of what a page has not.
/** @type {(name: string, hidden: boolean) => void} */
function hideSwitch(name, hidden) {
  element(`show-${name}`).closest("label")?.toggleAttribute("hidden", hidden);
}

// Connect the controls that both pages have. A page adds buttons and keys with their actions, and
// `takes`, which returns whether an event of the keyboard is handled already.
/** @type {(stage: Stage, controls: StageControls) => void} */
function connectStage(stage, { buttons, keys, pointers, takes }) {
  /** @type {Actions} */
  const actions = {
    "zoom-in": () => stage.zoom(ZOOM_STEP),
    "zoom-out": () => stage.zoom(1 / ZOOM_STEP),
    fit: () => stage.setFollow("field"),
    follow: () => stage.setFollow(stage.follow === "head" ? "field" : "head"),
    language: () => stage.setLanguage(otherLanguage()),
    help: () => element("about").showModal(),
    close: () => element("about").close(),
    ...buttons,
  };
  for (const [id, action] of Object.entries(actions)) element(id).addEventListener("click", action);
  for (const name of Object.keys(stage.shown)) {
    const box = element(`show-${name}`);
    box.addEventListener("change", () => {
      stage.shown[name] = box.checked;
      stage.afterChange();
    });
  }
  listenToKeys(
    {
      ...keysOfElements(),
      "=": actions["zoom-in"], // the key of "+" without shift
      w: () => stage.pan(0, -1),
      a: () => stage.pan(-1, 0),
      s: () => stage.pan(0, 1),
      d: () => stage.pan(1, 0),
      ...keys,
    },
    takes,
  );
  listenToPointers(element("field"), stage.view, {
    moved: (how) => stage.viewMoved(how),
    hovered(pixel) {
      stage.pixel = pixel;
      stage.requestDraw();
    },
    ...pointers,
  });
  stage.watch();
}

// Keys that click an element, unless it is hidden.
/** @type {() => Actions} */
function keysOfElements() {
  /** @type {(each: HTMLElement) => () => void} */
  const click = (each) => () => each.checkVisibility() && each.click();
  return Object.fromEntries(
    withKeys().map(([each, key]) => [key === "Space" ? " " : key.toLowerCase(), click(each)]),
  );
}

/** @type {(actions: Actions, takes?: Takes) => void} */
function listenToKeys(actions, takes = () => false) {
  let tabbed = false; // Whether a key has moved the focus, and not the pointer.
  document.addEventListener(
    "pointerdown",
    () => {
      tabbed = false;
    },
    true,
  );
  document.addEventListener("keydown", (event) => {
    if (event.key === "Tab") tabbed = true;
    const key = event.key.toLowerCase();
    // With one of these keys another is the browser's.
    const isOwn = !(event.ctrlKey || event.metaKey || event.altKey) || MODIFIERS.test(key);
    if (!isOwn || element("about").open) return;
    const kept = keepsKey(event.target, key, tabbed);
    // An element that a key has reached also keeps the keys of a program.
    if (!(kept && tabbed) && takes(event)) return;
    if (!actions[key] || kept) return;
    event.preventDefault();
    if (!event.repeat || REPEATED.test(key)) actions[key](event);
  });
  document.addEventListener("keyup", (event) => {
    const kept = element("about").open || event.key !== " " || keepsKey(event.target, " ", tabbed);
    // Otherwise Firefox would click the button.
    if (takes(event) || !kept) event.preventDefault();
  });
}

// Keys that an element uses itself. The space bar is that
// of an element which a key has reached, and not a click.
/** @type {(target: any, key: string, tabbed: boolean) => boolean} */
function keepsKey(target, key, tabbed) {
  if (target.matches("input[type=number]")) return true;
  if (key === " ") {
    return (
      tabbed && target.matches("button, select, summary, input:not([type=range], [type=radio])")
    );
  }
  if (key === "enter") return target !== element("field");
  if (target.matches("input[type=range]")) {
    return target.id !== "time" && /^(arrow|page|home|end)/.test(key);
  }
  return (
    target.matches("select") || (target.matches("input[type=radio]") && key.startsWith("arrow"))
  );
}

// Show why a page does not work.
/** @type {(error: { message: string }) => void} */
function showFailure({ message }) {
  element("failure").hidden = false;
  setText(
    "failure",
    localized("The page cannot start: {message}. A newer browser may help.", { message }),
  );
}
