// Starts the player, and offers it to others.

async function started() {
  try {
    const told = JSON.parse(block("told"));
    const [packed, velocities, curve] = await Promise.all(["handles", "velocities", "curve"].map(
      (name) => told[name] && unpacked(told[name], block(`${name}-packed`))));
    const player = new Player(told, packed, velocities, curve);
    if (!told.grid) element("show-grid").closest("label").hidden = true;
    element("precision").textContent = `Places are kept to ${Number((1e6 * told.errors[0]).toPrecision(2))} μm`
      + ` in ${packed.frames} frames; between two frames, benches move on cubic polynomials of time that have the places`
      + " and velocities of both. No number has more digits than that allows.";
    connect(player);
    player.readLink();
    player.draw();
    return offered(player);
  } catch (error) {
    element("failure").hidden = false;
    element("failure").textContent = `The dragon cannot be shown: ${error.message}. A newer browser may help.`;
    throw error;
  }
}

// For lessons that hold the page in a frame: `frame.contentWindow.dragon.then((player) => player.seek(409.8))`.
function offered(player) {
  const { motion, view } = player;
  return Object.freeze({
    play: () => player.play(),
    pause: () => player.pause(),
    seek: (time) => player.seek(time),
    draw: () => player.draw(),
    get time() { return player.time; },
    get playing() { return player.playing; },
    get view() { return { x: view.x, y: view.y, scale: view.scale, follow: player.follow }; },
    // Pixels of the canvas at a point of the floor.
    pixel: (x, y) => view.toScreen(x, y),
    // Places of the handles in a frame, x and y in turn.
    handles: (frame) => Array.from(vectorsIn(player.motion.packed, frame)),
    // Poses [x, y, angle] of the benches at a time.
    poses: (time) => {
      const { x, y, angle } = motion.posesAt(time);
      return Array.from(x, (_, i) => [x[i], y[i], angle[i]]);
    },
    // Of one bench, now: what the card tells, and the cells [row, column] that it is filed under.
    numbers: (bench) => numbersOf(new Benches(motion, motion.posesAt(player.time)), bench, player.time),
    cells: (bench) => new Benches(motion, motion.posesAt(player.time)).cells(bench, player.painter.told.grid),
  });
}

globalThis.dragon = started();
