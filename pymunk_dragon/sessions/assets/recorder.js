// Films the canvas.

const FILM_TYPES = ["video/mp4", "video/webm"]; // the first one that the browser can write
const FILM_RATE = 30; // pictures a second

class Recorder {
  constructor(live) {
    this.live = live;
    this.film = null;
  }

  toggle() {
    if (this.film) this.film.stop();
    else this.begin();
    this.show();
  }

  show() {
    document.body.classList.toggle("recording", this.film !== null);
    setText("record-text", this.film ? localized("Stop") : localized("Film"));
  }

  begin() {
    const canvas = element("field");
    const type = FILM_TYPES.find((each) => globalThis.MediaRecorder?.isTypeSupported(each));
    if (!type || !canvas.captureStream) return;
    const parts = [];
    this.film = new MediaRecorder(canvas.captureStream(FILM_RATE), { mimeType: type });
    this.film.addEventListener("dataavailable", ({ data }) => parts.push(data));
    this.film.addEventListener("stop", () => {
      this.film = null;
      this.show();
      download(new Blob(parts, { type }), `live.${type.slice("video/".length)}`);
    });
    this.film.start();
    this.live.requestDraw(); // the stream begins with the next picture
  }
}
