// Legend of the forces and a scale bar, at the lower border of the canvas.

const LEGEND_LEFT = 14; // pixels from the left side
const LEGEND_BOTTOM = 14; // pixels from the lower side
const LEGEND_WIDTH = 168; // pixels
const LEGEND_ROOM = 50; // pixels: height of the legend, below the scale bar
const LEGEND_HEIGHT = 9; // pixels
const BAR_LONGEST = 110; // pixels: longest scale bar
const BACKING = 0.8; // opacity of the ground behind legend and scale bar

// A ground of the background's colour, so that benches do not hide the numbers.
function drawBacking({ context, view, colours }, width, height) {
  context.globalAlpha = BACKING;
  context.fillStyle = colours.background;
  context.beginPath();
  context.roundRect(LEGEND_LEFT - 8, view.height - LEGEND_BOTTOM + 6 - height, width + 16, height, 6);
  context.fill();
  context.globalAlpha = 1;
}

function drawLegend(painter) {
  const { context, view, colours, forceScale } = painter;
  drawBacking(painter, LEGEND_WIDTH, LEGEND_ROOM);
  const top = view.height - LEGEND_BOTTOM - LEGEND_HEIGHT - 16;
  const strip = context.createLinearGradient(LEGEND_LEFT, 0, LEGEND_LEFT + LEGEND_WIDTH, 0);
  RAMP.forEach((colour, k) => strip.addColorStop(k / (RAMP.length - 1), colour));
  context.fillStyle = strip;
  context.strokeStyle = colours.text;
  context.lineWidth = 1;
  context.fillRect(LEGEND_LEFT, top, LEGEND_WIDTH, LEGEND_HEIGHT);
  context.strokeRect(LEGEND_LEFT, top, LEGEND_WIDTH, LEGEND_HEIGHT);
  context.font = `11px ${painter.font}`;
  context.textBaseline = "alphabetic";
  context.textAlign = "left";
  painter.drawText(localized("Force in the joint ({unit})", { unit: painter.model.forceUnit }), LEGEND_LEFT, top - 6);
  ["left", "center", "right"].forEach((align, k) => {
    context.textAlign = align;
    const text = powerText(forceScale.bottom + k * DECADES / 2);
    painter.drawText(text, LEGEND_LEFT + k * LEGEND_WIDTH / 2, top + LEGEND_HEIGHT + 13);
  });
}

// A length of 1, 2 or 5 times a power of ten m, and a line of that length.
function drawScaleBar(painter, above) {
  const { context, view, colours } = painter;
  const longest = BAR_LONGEST / view.scale;
  const power = 10 ** Math.floor(Math.log10(longest));
  const length = [5, 2, 1].find((digit) => digit * power <= longest) * power;
  const y = view.height - LEGEND_BOTTOM - above, right = LEGEND_LEFT + length * view.scale;
  const path = new Path2D();
  for (const corner of [[LEGEND_LEFT, y - 5], [LEGEND_LEFT, y], [right, y], [right, y - 5]]) path.lineTo(...corner);
  strokeTwice(context, path, colours.background, colours.text, 1.5);
  context.font = `11px ${painter.font}`;
  context.textAlign = "left";
  context.textBaseline = "alphabetic";
  const short = painter.model.units === "m" && length < 1;
  painter.drawText(short ? `${Number((1000 * length).toPrecision(1))} mm` : `${length} ${painter.model.units}`, right + 6, y);
}
