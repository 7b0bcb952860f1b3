// Buttons, fields and keys of the player.

const TIMELINE_STEP = 2; // times
const WHOLE_TIMELINE = 1e-9; // times: so little is the whole run
const TOUCH_SLIP = 12; // pixels: largest distance of a touch from the bench that it selects

/** @type {(player: Player) => void} */
function connectPlayer(player) {
  const { view, timeline } = player;
  connectPlayerFields(player);
  connectStage(player, {
    buttons: playerButtons(player),
    keys: {
      home: () => player.seek(player.recording.begin),
      end: () => player.seek(player.recording.end),
    },
    pointers: {
      tapped(pixel, kind) {
        const slip = kind === "mouse" ? 0 : TOUCH_SLIP / view.scale;
        const found = bodyAt(view.toWorld(...pixel), slip, player.moment);
        player.set("selected", found?.bench ?? null);
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
const playerButtons = (player) => ({
  play: () => player.toggle(),
  back: () => player.toNext(player.recording.times, -1),
  forward: () => player.toNext(player.recording.times, 1),
  previous: () => player.toNext(player.eventTimes, -1),
  next: () => player.toNext(player.eventTimes, 1),
  last: () => player.playLast(),
  "timeline-in": () => player.zoomTimeline(TIMELINE_STEP),
  "timeline-out": () => player.zoomTimeline(1 / TIMELINE_STEP),
  "timeline-all": () => player.zoomTimeline(WHOLE_TIMELINE),
});

/** @type {(player: Player) => void} */
function connectPlayerFields(player) {
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
