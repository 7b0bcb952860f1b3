// Texts that a program draws on the picture.

const LINE_HEIGHT = 1.25; // times the size of the letters
const TEXT_RIM = 4; // pixels, as that of other texts

// The middle of a text is at its point.
/** @type {Layer<LivePicture>} */
function drawTexts(painter, { texts }) {
  const { context, colours, view } = painter;
  Object.assign(context, { strokeStyle: colours.background, lineWidth: TEXT_RIM });
  for (const [x, y, text, size, [red, green, blue, alpha]] of texts) {
    const [px, py] = view.toScreen(x, y);
    const lines = text.split("\n");
    painter.setFont(`600 ${size}px`, "center", "middle");
    context.fillStyle = `rgba(${red}, ${green}, ${blue}, ${alpha / 255})`;
    lines.forEach((line, i) => {
      const below = (i - (lines.length - 1) / 2) * LINE_HEIGHT * size;
      context.strokeText(line, px, py + below);
      context.fillText(line, px, py + below);
    });
  }
}
