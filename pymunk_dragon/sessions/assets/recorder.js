// Records: the server keeps a run, and this page films its canvas meanwhile.

const FILM_TYPES = ["video/mp4", "video/webm"]; // the first one that the browser can write
const FILM_RATE = 30; // pictures a second

class Recorder {
  constructor(live) {
    this.live = live;
    this.film = null;
    this.address = null;
  }

  // Begin, or end what anybody began.
  toggle() {
    const { recording } = this.live.state;
    this.live.send({ do: recording ? "finish" : "record" });
    if (!recording) this.begin();
  }

  begin() {
    this.hide();
    const canvas = element("field");
    const type = FILM_TYPES.find((each) => globalThis.MediaRecorder?.isTypeSupported(each));
    if (!type || !canvas.captureStream) return;
    const parts = [];
    this.film = new MediaRecorder(canvas.captureStream(FILM_RATE), { mimeType: type });
    this.film.addEventListener("dataavailable", ({ data }) => parts.push(data));
    this.film.addEventListener("stop", () => this.offerFilm(new Blob(parts, { type })));
    this.film.start();
    this.live.requestDraw(); // the stream begins with the next picture
  }

  // The server's state has changed; a recording of ten minutes ends by itself.
  update({ recording, recorded }) {
    const began = this.recording === false && recording, ended = this.recording === true && !recording;
    this.recording = recording;
    document.body.classList.toggle("recording", recording);
    setText("record-text", recording ? localized("Stop") : localized("Record"));
    if (began && this.film === null) this.hide();
    if (!ended) return;
    this.film?.stop();
    this.film = null;
    element("run").href = `run${location.search}`;
    element("run").hidden = recorded === null;
    setText("recorded-text", recorded === null ? localized("Recorded:") : localized("{time} s recorded:", { time: recorded.toFixed(1) }));
    element("recorded").hidden = false;
  }

  offerFilm(blob) {
    this.address = URL.createObjectURL(blob);
    Object.assign(element("film"), { href: this.address, download: `live.${blob.type.includes("mp4") ? "mp4" : "webm"}`, hidden: false });
  }

  hide() {
    element("recorded").hidden = element("film").hidden = true;
    if (this.address) URL.revokeObjectURL(this.address);
    this.address = null;
  }
}
