// Films the field.

// The first one that the browser can write. H.264 has to be named: Chromium writes VP9 into an MP4
// without a codec, and fewer players know that.
const FILM_TYPES = ["video/mp4;codecs=avc1", "video/webm", "video/mp4"];
const FILM_RATE = 30; // pictures a second
// Most pixels of a picture: levels of H.264 end at 36,864 blocks of 16 x 16 pixels,
// not all of which are full.
const FILM_PIXELS = 4096 * 2160;

// H.264 has only even sizes.
/** @type {(size: number) => number} */
const even = (size) => Math.max(2, 2 * Math.floor(size / 2));

class Recorder {
  /** @param {Live} live */
  constructor(live) {
    this.live = live;
    /** @type {MediaRecorder | null} */
    this.film = null;
    this.canvas = created("canvas");
    this.context = /** @type {CanvasRenderingContext2D} */ (
      this.canvas.getContext("2d", { alpha: false })
    );
    this.width = 0;
    this.height = 0;
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
    const { canvas } = this;
    const type = FILM_TYPES.find((each) => globalThis.MediaRecorder?.isTypeSupported(each));
    if (!type || !canvas.captureStream) return;
    this.setSize(element("field"));
    const film = (this.film = new MediaRecorder(canvas.captureStream(FILM_RATE), {
      mimeType: type,
    }));
    /** @type {Blob[]} */
    const parts = [];
    film.addEventListener("dataavailable", ({ data }) => parts.push(data));
    film.addEventListener("stop", () => {
      this.film = null;
      this.show();
      // What was written, which the browser may choose: video/mp4;codecs=avc1.42001f
      const [, ending] = film.mimeType.split(/[/;]/);
      download(new Blob(parts, { type: film.mimeType }), `live.${ending}`);
    });
    film.start();
    this.live.requestDraw(); // the stream begins with the next picture
  }

  // All pictures of a film have the size of the field when it began,
  // less the last pixel of an odd one.
  /** @type {(field: { width: number, height: number }) => void} */
  setSize({ width, height }) {
    const scale = Math.min(1, Math.sqrt(FILM_PIXELS / (width * height)));
    this.width = scale * width;
    this.height = scale * height;
    Object.assign(this.canvas, { width: even(this.width), height: even(this.height) });
  }

  // Film what the field shows; a field of another shape by now has bars beside it.
  add() {
    if (!this.film) return;
    const { canvas, context } = this;
    const field = element("field");
    const scale = Math.min(this.width / field.width, this.height / field.height);
    const width = scale * field.width;
    const height = scale * field.height;
    const left = Math.max(0, Math.floor((canvas.width - width) / 2));
    const top = Math.max(0, Math.floor((canvas.height - height) / 2));
    context.fillStyle = this.live.colours.background;
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.drawImage(field, left, top, width, height);
  }
}
