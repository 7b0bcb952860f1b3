// Buttons, fields and keys of the player.

const TIMELINE_STEP = 2; // times
const WHOLE_TIMELINE = 1e-9; // times: so little is the whole run
const TOUCH_SLIP = 12; // pixels: largest distance of a touch from the bench that it selects

/** @type {(player: Player) => void} */
function connect(player) {
  const { view, timeline } = player;
  connectFields(player);
  connectStage(player, {
    buttons: buttonsOf(player),
    keys: {
      home: () => player.seek(player.motion.begin),
      end: () => player.seek(player.motion.end),
    },
    pointers: {
      tapped(pixel, kind) {
        const slip = kind === "mouse" ? 0 : TOUCH_SLIP / view.scale;
        player.set("selected", player.benches.at(view.toWorld(...pixel), slip));
      },
    },
  });
  listenToPointers(element("strip"), timeline, {
    moved: () => player.requestDraw(),
    hovered: () => {},
    tapped: ([px]) => player.seek(timeline.timeOfClick(px)),
  });
  listenToWheel(element("time"), timeline, () => player.requestDraw());
  const moving = [element("play"), element("back"), element("forward"), element("last")];
  for (const each of [element("time"), ...moving]) each.disabled = player.length === 0;
  for (const each of [element("previous"), element("next"), element("events")]) {
    each.disabled = !player.events.length;
  }
  addEventListener("hashchange", () => player.readLink());
}

/** @type {(player: Player) => Actions} */
const buttonsOf = (player) => ({
  play: () => player.toggle(),
  back: () => player.toNext(player.motion.times, -1),
  forward: () => player.toNext(player.motion.times, 1),
  previous: () => player.toNext(player.eventTimes, -1),
  next: () => player.toNext(player.eventTimes, 1),
  last: () => player.playLast(),
  "timeline-in": () => player.zoomTimeline(TIMELINE_STEP),
  "timeline-out": () => player.zoomTimeline(1 / TIMELINE_STEP),
  "timeline-all": () => player.zoomTimeline(WHOLE_TIMELINE),
});

/** @type {(player: Player) => void} */
function connectFields(player) {
  const time = element("time");
  const rate = element("rate");
  const slow = element("slow");
  const events = element("events");
  const bench = element("bench");
  rate.append(...RATES.map((each) => new Option(`${each}×`, String(each))));
  writeLists(player);
  time.addEventListener("input", () => player.seek(time.valueAsNumber));
  rate.addEventListener("change", () => player.set("rate", Number(rate.value)));
  slow.addEventListener("change", () => player.set("slow", slow.checked));
  events.addEventListener("change", () => {
    if (events.value !== "") player.seek(player.events[Number(events.value)].time);
    events.value = "";
  });
  bench.addEventListener("input", () => {
    if (bench.value !== "" && bench.checkValidity()) player.set("selected", bench.valueAsNumber);
  });
}

// Events to go to, and the precision of the run, in the page's language.
/** @type {(player: Player) => void} */
function writeLists({ events, motion }) {
  const first = events.length ? localized("Go to an event …") : localized("No events");
  const options = events.map(
    ({ time, text }, i) => new Option(`${time.toFixed(2)} s: ${text}`, String(i)),
  );
  element("events").replaceChildren(new Option(first, ""), ...options);
  setText(
    "precision",
    localized(
      "Positions are stored to within {error} μm in {frames} frames; between two frames," +
        " benches move on cubic polynomials of time that match the positions and velocities of" +
        " both. Numbers are shown with the digits that are certain.",
      { error: Number((1e6 * motion.positionError).toPrecision(2)), frames: motion.times.length },
    ),
  );
}
