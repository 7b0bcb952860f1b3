// Texts that a program draws on the picture.

const LINE_HEIGHT = 1.25; // times the size of the letters
const TEXT_RIM = 4; // pixels, as that of other texts
const DARK = 128; // of 255: darker letters have a light rim

// The middle of a text is at its point.
/** @type {Layer<LivePicture>} */
function drawTexts(painter, { texts }) {
  const { context, colours, view } = painter;
  context.lineWidth = TEXT_RIM;
  for (const [x, y, text, size, colour] of texts) {
    const [px, py] = view.toScreen(x, y);
    const lines = text.split("\n");
    painter.setFont(`600 ${size}px`, "center", "middle");
    context.fillStyle = colours.text;
    context.strokeStyle = colours.background;
    if (colour) {
      const [red, green, blue, alpha] = colour;
      context.fillStyle = `rgba(${red}, ${green}, ${blue}, ${alpha / 255})`;
      // Readable on any ground, also on shapes.
      const brightness = 0.3 * red + 0.59 * green + 0.11 * blue;
      context.strokeStyle = brightness < DARK ? "white" : "black";
    }
    lines.forEach((line, i) => {
      const below = (i - (lines.length - 1) / 2) * LINE_HEIGHT * size;
      context.strokeText(line, px, py + below);
      context.fillText(line, px, py + below);
    });
  }
}
