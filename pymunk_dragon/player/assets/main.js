// Starts the player and publishes its interface.

async function start() {
  try {
    const payload = JSON.parse(block("payload"));
    const [packed, velocities, curve] = await Promise.all(["handles", "velocities", "curve"].map(
      (name) => payload[name] && unpack(payload[name], block(`${name}-packed`))));
    const player = new Player(payload, packed, velocities, curve);
    if (!payload.grid) element("show-grid").closest("label").hidden = true;
    element("precision").textContent = `Positions are stored to within ${Number((1e6 * payload.errors[0]).toPrecision(2))} μm`
      + ` in ${packed.frames} frames; between two frames, benches move on cubic polynomials of time that match the`
      + " positions and velocities of both. Numbers are shown with the digits that are certain.";
    connect(player);
    player.readLink();
    player.draw();
    return publicPlayer(player);
  } catch (error) {
    element("failure").hidden = false;
    element("failure").textContent = `The dragon cannot be shown: ${error.message}. A newer browser may help.`;
    throw error;
  }
}

// For pages that hold this one in a frame: `frame.contentWindow.dragon.then((player) => player.seek(409.8))`.
function publicPlayer(player) {
  const { motion, view } = player;
  return Object.freeze({
    play: () => player.play(),
    pause: () => player.pause(),
    seek: (time) => player.seek(time),
    draw: () => player.draw(),
    get time() { return player.time; },
    get playing() { return player.playing; },
    get view() { return { x: view.x, y: view.y, scale: view.scale, follow: player.follow }; },
    // Pixel of the canvas at a point in m.
    pixel: (x, y) => view.toScreen(x, y),
    // Positions of the handles in a frame: x0, y0, x1, y1, ...
    handles: (frame) => Array.from(vectorsIn(player.motion.packed, frame)),
    // Poses [x, y, angle] of the benches at a time.
    poses: (time) => {
      const { x, y, angle } = motion.posesAt(time);
      return Array.from(x, (_, i) => [x[i], y[i], angle[i]]);
    },
    // Numbers of a bench at the current time, and the grid cells [row, column] that it covers.
    numbers: (bench) => benchNumbers(new Benches(motion, motion.posesAt(player.time)), bench, player.time),
    cells: (bench) => new Benches(motion, motion.posesAt(player.time)).cells(bench, player.painter.payload.grid),
  });
}

globalThis.dragon = start();
