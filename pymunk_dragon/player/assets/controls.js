// Buttons, fields and keys of the player.

const TIMELINE_STEP = 2; // times
const WHOLE_TIMELINE = 1e-9; // times: so little is the whole run
const TOUCH_SLIP = 12; // pixels: largest distance of a touch from the bench that it selects

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
  for (const id of ["time", "play", "back", "forward", "last"]) {
    element(id).disabled = player.length === 0;
  }
  for (const id of ["previous", "next", "events"]) element(id).disabled = !player.events.length;
  addEventListener("hashchange", () => player.readLink());
}

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

function connectFields(player) {
  element("rate").append(...RATES.map((rate) => new Option(`${rate}×`, rate)));
  writeLists(player);
  element("time").addEventListener("input", ({ target }) => player.seek(target.valueAsNumber));
  element("rate").addEventListener("change", ({ target }) =>
    player.set("rate", Number(target.value)),
  );
  element("slow").addEventListener("change", ({ target }) => player.set("slow", target.checked));
  element("events").addEventListener("change", ({ target }) => {
    if (target.value !== "") player.seek(player.events[target.value].time);
    target.value = "";
  });
  element("bench").addEventListener("input", ({ target }) => {
    if (target.value !== "" && target.checkValidity()) player.set("selected", target.valueAsNumber);
  });
}

// Events to go to, and the precision of the run, in the page's language.
function writeLists({ events, motion }) {
  const first = events.length ? localized("Go to an event …") : localized("No events");
  const options = events.map(({ time, text }, i) => new Option(`${time.toFixed(2)} s: ${text}`, i));
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
