// Writes scene, state and frame into the controls.

const SPEEDS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20]; // simulated over real time

function showScene(live) {
  const { scene, model } = live;
  document.title = scene.title;
  setText("title", scene.title);
  setText("text", scene.lesson ? `${scene.text} Lesson: pymunk-dragon demo ${scene.lesson}` : scene.text);
  const list = element("scene");
  list.replaceChildren(...scene.scenes.map(({ name, title }) => new Option(title, name)));
  list.value = scene.name;
  element("field").setAttribute("aria-label", model.benches
    ? `${scene.title}: ${model.benches} benches seen from above`
    : `${scene.title}: ${scene.bodies.length} bodies`);
  showAbilities(live);
}

function showAbilities(live) {
  const { model } = live;
  for (const name of SWITCHES) element(`show-${name}`).closest("label").hidden = !live.hasSwitch(name);
  for (const [id, ability] of [["dancers", "dancers"], ["contacts-row", "contacts"], ["speed-row", "speed"]]) {
    element(id).hidden = !model.can(ability);
  }
  element("follow").hidden = model.benches === 0;
  element("parameters-part").hidden = live.scene.parameters.length === 0;
  live.afterView();
}

function showState(live) {
  const { state } = live;
  document.body.classList.toggle("playing", state.running);
  const name = state.running ? "Pause" : "Play";
  element("play").setAttribute("aria-label", name);
  element("play").title = `${name} (space)`;
  showSpeed(state.speed);
  element("scene").value = live.scene.name;
  element("contacts").value = state.contacts;
  live.recorder.update(state);
  setText("clients", state.clients === 1 ? "1 viewer" : `${state.clients} viewers`);
  showAccess(live);
}

// The list has the usual speeds, and the server's if it is another one.
function showSpeed(speed) {
  const list = element("speed");
  const speeds = [...new Set([...SPEEDS, speed])].sort((one, two) => one - two);
  if (list.options.length !== speeds.length || !speeds.every((value, k) => Number(list.options[k].value) === value)) {
    list.replaceChildren(...speeds.map((value) => new Option(`${value}×`, value)));
  }
  list.value = speed;
}

// Controls that send are disabled for those who watch, and while there is no connection.
function showAccess(live) {
  for (const control of document.querySelectorAll(".sends")) control.disabled = !live.controls;
  const role = live.state?.replaying ? "Replay" : live.scene?.role === "watch" ? "Watching" : "";
  setText("role", role);
  element("role").hidden = role === "";
}

function showFrame({ frame, state, connection }) {
  setText("clock", frame.time.toFixed(2));
  setText("march", Number.isFinite(frame.marchTime) ? `March: ${frame.marchTime.toFixed(2)} s` : "");
  const slow = state.running && frame.rate < SLOW * state.speed;
  const rate = `${frame.rate.toFixed(2)}×`;
  setText("achieved", !state.running ? "Paused" : slow ? `Slow: ${rate}` : `${rate} real time`);
  element("achieved").classList.toggle("slow", slow);
  setText("latency", connection.latency === null ? "" : `${Math.max(1, Math.round(connection.latency))} ms away`);
}
