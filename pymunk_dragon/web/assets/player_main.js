// Starts the player and publishes its interface.

const PACKED = ["handles", "velocities", "exact", "curve"];

async function startPlayer() {
  const payload = JSON.parse(block("payload"));
  /** @type {Record<string, Packed>} */
  const packed = {};
  for (const name of PACKED) {
    packed[name] = payload[name] && (await unpack(payload[name], block(`${name}-packed`)));
  }
  const recording = new Recording(payload, packed);
  const player = new Player(recording);
  if (!recording.grid) hideSwitch("grid", true);
  for (const part of document.querySelectorAll(".exact-only")) {
    part.toggleAttribute("hidden", !recording.exact);
  }
  setLanguage(chosenLanguage());
  connectPlayer(player);
  player.readLink();
  player.draw();
  return publicPlayer(player);
}

// For pages that hold this one in a frame:
// `frame.contentWindow.dragon.then((player) => player.seek(409.8))`.
/** @param {Player} player */
function publicPlayer(player) {
  const { recording, view } = player;
  /** @type {(poses: Poses | null | undefined) => number[][] | null} */
  const rows = (poses) => poses?.x.map((x, i) => [x, poses.y[i], poses.angle[i]]) ?? null;
  return Object.freeze({
    play: () => player.play(),
    pause: () => player.pause(),
    seek: (/** @type {number} */ time) => player.seek(time),
    draw: () => player.draw(),
    get time() {
      return player.time;
    },
    get playing() {
      return player.playing;
    },
    get view() {
      return { x: view.x, y: view.y, scale: view.scale, follow: player.follow };
    },
    // Pixel of the canvas at a point in m.
    pixel: (/** @type {number} */ x, /** @type {number} */ y) => view.toScreen(x, y),
    // Positions of the handles in a frame: x0, y0, x1, y1, ...
    handles: (/** @type {number} */ frame) => Array.from(vectorsIn(recording.packed, frame)),
    // Poses [x, y, angle] at a time of the benches, and of the exact model; null if unknown.
    poses: (/** @type {number} */ time) => rows(recording.posesAt(time)),
    exactPoses: (/** @type {number} */ time) =>
      rows(recording.ghostsAt(time, recording.momentAt(time).benches, 1)?.benches.poses),
    get rate() {
      return player.currentRate;
    },
    get timeline() {
      return [player.timeline.from, player.timeline.to];
    },
    // Numbers of a bench at the current time.
    numbers: (/** @type {number} */ bench) =>
      benchNumbers(recording.momentAt(player.time).benches, bench, player.time),
  });
}

globalThis.dragon = startPlayer();
globalThis.dragon.catch(showFailure);
