// Writes scene, state and frame into the controls.

const SPEEDS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20]; // simulated over real time
const RATE_TIME = 1; // s: the rate of the simulation is an average of so long
const SLOW = 0.9; // less than this fraction of the chosen speed is marked as slow
const BUSY = 0.5; // of the time: longer steps are why a program with a loop of its own is slow
const LIVE_SWITCHES = ["curve", "handles", "labels", "exact", "forces", "contacts"];

// An event of the server, whose numbers are fields {i}, {j}, ... of a text in the catalogue.
/** @type {(text: string) => string} */
function translatedNumbers(text) {
  const numbers = text.match(/\d+/g) ?? [];
  const names = "ijk";
  let k = 0;
  const template = text.replace(/\d+/g, () => `{${names[k++]}}`);
  const found = translated(template);
  if (found === template) return text;
  return fill(found, Object.fromEntries(numbers.map((number, n) => [names[n], number])));
}

/** @type {(live: Live) => void} */
function showScene(live) {
  const { scene, model } = live;
  const title = (document.title = translated(scene.title));
  setText("title", title);
  setText("text", translated(scene.text));
  setText(
    "force-name",
    model.benches
      ? localized("Tension along the chain (N)")
      : localized("Force by joint ({unit})", { unit: model.unitOf.force }),
  );
  setText("torque-name", localized("Torque by joint ({unit})", { unit: model.unitOf.torque }));
  live.sliders.setParameters(scene.parameters);
  showLesson(scene);
  element("reset").title = scene.given
    ? localized(
        "Start again: all is as it was at first, sliders too;" +
          " where bodies touch, the run may differ",
      )
    : localized("Start again: all is as it was at first, sliders too");
  for (const id of ["save", "about-save"]) {
    element(id).hidden = IN_WIDGET || SITE !== null || !scene.replays;
  }
  const list = element("scene");
  list.replaceChildren(
    ...scene.scenes.map((each) => new Option(translated(each.title), each.name)),
  );
  list.value = scene.name;
  element("field").setAttribute(
    "aria-label",
    model.benches
      ? localized("{title}: {count} benches seen from above", { title, count: model.benches })
      : title,
  );
  showAbilities(live);
}

// A link to the lesson of a scene, if its page is on this server;
// otherwise the command that shows it.
/** @type {(scene: LiveScene) => void} */
function showLesson({ lesson }) {
  const here = SITE ? Boolean(SITE.lessons) : location.pathname.endsWith("/live");
  const link = element("lesson");
  const option = language === "en" ? "" : ` --lang ${language}`;
  const command = `pymunk-dragon demo --live ${lesson}${option}`;
  setText("lesson", lesson ? localized("Lesson: {name}", { name: here ? lesson : command }) : "");
  // Without a text it would be a link that nobody can name.
  link.hidden = !lesson;
  if (here) link.href = `./${SITE?.lessons ?? ""}${location.search}#${lesson}`;
}

/** @type {(live: Live) => void} */
function showAbilities(live) {
  const { model } = live;
  for (const name of LIVE_SWITCHES) {
    hideSwitch(name, !live.hasSwitch(name));
  }
  /** @type {Record<string, string>} */
  const parts = {
    dancers: "dancers",
    "contacts-row": "contacts",
    "until-contact": "until_contact",
  };
  for (const id in parts) element(id).hidden = !model.can(parts[id]);
  showFollow(live);
  document.body.classList.toggle("of-benches", model.benches > 0);
  element("about-given").hidden = !live.scene.given;
  element("about-clicks").hidden = !live.scene.clicks;
  element("parameters-part").hidden = live.scene.parameters.length === 0;
  const buttons = live.scene.buttons.map((name) => {
    const onclick = () => live.send({ do: "press", name, down: true });
    return created("button", { type: "button", className: "plain sends", onclick }, name);
  });
  element("actions").replaceChildren(...buttons);
  showKeyButtons(live);
  // The help has no keys of what the scene has not.
  for (const [k, [each]] of withKeys().entries()) {
    element("keys").children[k].toggleAttribute("hidden", each.closest("[hidden]") !== null);
  }
  live.charts.nameViews();
  live.afterChange();
}

/** @type {(live: Live) => void} */
function showFollow({ model, scene }) {
  const button = element("follow");
  button.hidden = model.benches === 0 && !scene.follows;
  const what = scene.follows ? localized("Follow") : localized("Follow the head");
  const sign = keySign(button.getAttribute("aria-keyshortcuts") ?? "");
  Object.assign(button, { ariaLabel: what, title: `${what} (${sign})` });
}

/** @type {(live: Live) => void} */
function showState(live) {
  const { state } = live;
  showPlaying(state.running);
  showSpeed(state.speed);
  element("scene").value = live.scene.name;
  element("contacts").value = state.contacts;
  live.recorder.show();
  const { clients: count } = state;
  setText("clients", count === 1 ? localized("1 viewer") : localized("{count} viewers", { count }));
  showAccess(live);
}

// The list has the usual speeds, and the server's if it is another one.
/** @type {(speed: number) => void} */
function showSpeed(speed) {
  const list = element("speed");
  const speeds = [...new Set([...SPEEDS, speed])].sort((one, two) => one - two);
  const options = speeds.map((value) => new Option(`${value}×`, String(value)));
  if (list.textContent !== options.map(({ text }) => text).join("")) {
    list.replaceChildren(...options);
  }
  list.value = String(speed);
}

// Controls that send are disabled for those who watch, and while there is no connection.
/** @type {(live: Live) => void} */
function showAccess(live) {
  /** @type {NodeListOf<HTMLInputElement>} */
  const sending = document.querySelectorAll(".sends, .toolbox input");
  for (const control of sending) control.disabled = !live.controls;
  // A program that makes the steps itself builds its space once.
  for (const control of [element("reset"), element("scene")]) {
    control.disabled ||= !live.scene?.resets;
  }
  const role = live.state?.replaying
    ? localized("Replay")
    : live.scene?.role === "watch"
      ? localized("Watching")
      : "";
  setText("role", role);
  element("role").hidden = role === "";
}

// Simulated over real time in the last second, by the session's clock;
// null in the first moments after a change.
/** @type {(live: Live) => number | null} */
function rateOf(live) {
  const {
    state: { running, speed },
    frame: { generation, clock, time, step, step_time },
  } = live;
  const kind = [running, speed, generation].join();
  if (live.rateKind !== kind) Object.assign(live, { rateKind: kind, ticks: [] });
  live.ticks = [...live.ticks, { clock, time, step, step_time }].filter(
    (one) => one.clock >= clock - RATE_TIME,
  );
  const [first] = live.ticks;
  const passed = clock - first.clock;
  return passed >= RATE_TIME / 2 ? (time - first.time) / passed : null;
}

// Whether the computer is too slow for the chosen speed. A program that makes the steps itself may
// also be slow as it likes: then the steps take little of the time.
/** @type {(live: Live, rate: number) => boolean} */
function isSlow({ state, scene, ticks }, rate) {
  if (!state.running || rate >= SLOW * state.speed) return false;
  const steps = lastOf(ticks).step - ticks[0].step;
  const passed = lastOf(ticks).clock - ticks[0].clock;
  const mean = ticks.reduce((sum, { step_time }) => sum + step_time, 0) / ticks.length;
  return scene.resets || steps * mean > BUSY * passed;
}

/** @type {(live: Live) => void} */
function showFrame(live) {
  const { frame, state } = live;
  setText("clock", frame.time.toFixed(2));
  setText("march", marchText(frame));
  const now = rateOf(live);
  const known = now !== null;
  const slow = known && isSlow(live, now);
  const rate = known ? `${now.toFixed(2)}×` : "–";
  const achieved = slow
    ? localized("Slow: {rate}", { rate })
    : localized("{rate} real time", { rate });
  setText("achieved", state.running ? achieved : localized("Paused"));
  element("achieved").classList.toggle("slow", slow);
}

// Time of the exact model, or why it stands.
/** @type {(frame: LiveFrame) => string} */
function marchText({ march_time: time, waits, errors }) {
  if (!Number.isFinite(time)) return "";
  if (!waits) return localized("March: {time} s", { time: time.toFixed(2) });
  const worst = errors.reduce((one, value, i) => (value > errors[one] ? i : one), 0);
  const error = formatLength(errors[worst], 0);
  return localized("The march waits: bench {i} is {error} from its place", { i: worst, error });
}
