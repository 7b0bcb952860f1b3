// Starts the page and publishes what tests read.

function start() {
  try {
    const live = new Live();
    connect(live);
    setLanguage(chosenLanguage());
    return publicLive(live);
  } catch (error) {
    element("failure").hidden = false;
    const { message } = error;
    element("failure").textContent = localized("The page cannot start: {message}. A newer browser may help.", { message });
    throw error;
  }
}

function publicLive(live) {
  return Object.freeze({
    get scene() { return live.scene; },
    get state() { return live.state; },
    get frame() { return live.frame; },
    get connected() { return live.connection.connected; },
    get drawn() { return live.drawn; },
    // Pixel of the canvas at a point in m.
    pixel: (x, y) => live.view.toScreen(x, y),
    send: (message) => live.send(message),
  });
}

globalThis.live = start();
