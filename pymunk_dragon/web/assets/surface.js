// A canvas that is drawn again when what it shows, its size, or the colours of the page change.

// Those who extend it add `tick`, which draws.
class Surface {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.context = /** @type {CanvasRenderingContext2D} */ (
      canvas.getContext("2d", { alpha: false })
    );
    this.width = 1; // pixels
    this.height = 1;
    this.colours = readColours();
    this.font = fontOf(canvas);
    /** @type {number | null} */
    this.frameRequest = null;
  }

  // Draw again when the size or the colours change.
  watch() {
    new ResizeObserver(() => this.requestDraw()).observe(this.canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.readColours());
  }

  readColours() {
    this.colours = readColours();
    this.font = fontOf(this.canvas);
    this.requestDraw();
  }

  // Draw with the next picture of the browser.
  requestDraw() {
    this.frameRequest ??= requestAnimationFrame((now) => {
      this.frameRequest = null;
      this.tick(now);
    });
  }

  resize() {
    Object.assign(this, fitCanvas(this.canvas, this.context));
  }

  clear() {
    const { context } = this;
    context.fillStyle = this.colours.background;
    context.fillRect(0, 0, this.width, this.height);
    context.lineJoin = "round";
  }
}
