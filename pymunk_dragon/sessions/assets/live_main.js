// Starts the page and publishes what tests read.

function start() {
  const live = new Live();
  connect(live);
  setLanguage(chosenLanguage());
  return publicLive(live);
}

function publicLive(live) {
  return Object.freeze({
    get scene() { return live.scene; },
    get state() { return live.state; },
    get frame() { return live.frame; },
    get drawn() { return live.drawn; },
    // Pixel of the canvas at a point in m.
    pixel: (x, y) => live.view.toScreen(x, y),
    send: (message) => live.send(message),
  });
}

try {
  globalThis.live = start();
} catch (error) {
  showFailure(error);
  throw error;
}
