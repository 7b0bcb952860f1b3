// Keys of a scene's own: on the keyboard, and as buttons that a finger or the mouse can hold.

// What holds a key, a code of the keyboard or a button, presses or releases it. A key that two hold
// is released by the second.
/** @type {(live: Live, holder: string, name: string) => void} */
function pressKey(live, holder, name) {
  const { pressed } = live;
  const held = [...pressed.values()].includes(name);
  pressed.set(holder, name);
  if (!held) live.send({ do: "press", name, down: true });
}

/** @type {(live: Live, holder: string) => void} */
function releaseKey(live, holder) {
  const { pressed } = live;
  const name = pressed.get(holder);
  if (name === undefined) return;
  pressed.delete(holder);
  if (![...pressed.values()].includes(name)) live.send({ do: "press", name, down: false });
}

/** @type {(live: Live) => void} */
function releaseKeys(live) {
  for (const holder of [...live.pressed.keys()]) releaseKey(live, holder);
}

// Take a key of the scene's own, which then does nothing else; returns whether it is one. What is
// released is the key that went down: its name changes with the shift key.
/** @type {(live: Live, event: KeyboardEvent) => boolean} */
function takesKey(live, event) {
  const { pressed } = live;
  const code = event.code || event.key;
  if (event.type === "keyup") {
    const takes = pressed.has(code);
    releaseKey(live, code);
    return takes;
  }
  const keys = live.scene?.keys ?? [];
  const all =
    keys.includes("*") && !(/** @type {Element} */ (event.target).closest("input, select"));
  if (!(keys.includes(event.key) || all) || !live.controls) return false;
  event.preventDefault();
  if (!event.repeat && !pressed.has(code)) pressKey(live, code, event.key);
  return true;
}

// A button that is a key. It takes no focus from the field, which would release the keys that the
// keyboard holds; with the keyboard it is pressed and released at once.
/** @type {(live: Live, name: string) => HTMLElement} */
function keyButton(live, name) {
  const holder = `button ${name}`;
  const press = () => live.controls && pressKey(live, holder, name);
  const release = () => releaseKey(live, holder);
  return created(
    "button",
    {
      type: "button",
      className: "plain sends",
      ariaLabel: name === " " ? localized("space") : name,
      onpointerdown: (/** @type {PointerEvent} */ { button }) => button === 0 && press(),
      onpointerup: release,
      onpointercancel: release,
      onpointerleave: release,
      onmousedown: (/** @type {Event} */ event) => event.preventDefault(),
      oncontextmenu: (/** @type {Event} */ event) => event.preventDefault(),
      // A click of the keyboard has no number.
      onclick(/** @type {MouseEvent} */ { detail }) {
        if (detail) return;
        press();
        release();
      },
    },
    keySign(name),
  );
}

/** @type {(live: Live) => void} */
function showKeyButtons(live) {
  const keys = live.scene.keys.filter((key) => key !== "*");
  element("held-keys").hidden = keys.length === 0;
  element("held-keys").replaceChildren(...keys.map((key) => keyButton(live, key)));
}
