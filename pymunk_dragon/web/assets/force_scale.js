// Colours of bodies and forces, the scales of forces and torques,
// their legends and the scale bar at the lower border.

/** @type {Kind[]} */
const EFFORTS = ["force", "torque"];
/** @type {Record<Kind, string>} */
const EFFORT_TEXTS = {
  force: "Force in the joint ({unit})",
  torque: "Torque in the joint ({unit})",
};

// The forces, or torques, of joints.
/** @type {(joints: Effort[], kind: Kind) => number[]} */
const effortsOf = (joints, kind) =>
  joints.filter((joint) => joint.kind === kind).map(({ effort }) => effort);

// Pymunk's debug colours: of static shapes, of outlines and of collision points.
const STATIC_COLOUR = "#95a5a6";
const OUTLINE_COLOUR = "#2c3e50";
const COLLISION_COLOUR = "#e74c3c";
// Forces from small to large.
const RAMP = ["#ffffcc", "#fed976", "#fd8d3c", "#e31a1c", "#800026"];
const SHADES = 32; // colours of discs: those of one shade share a path

const SHADE_COLOURS = Array.from({ length: SHADES }, (_, shade) => {
  const place = (shade / (SHADES - 1)) * (RAMP.length - 1);
  const k = Math.min(Math.floor(place), RAMP.length - 2);
  return mixed(RAMP[k], RAMP[k + 1], place - k);
});

// A logarithmic scale whose upper end follows the largest value: it rises at once,
// and falls after some seconds.

const DECADES = 4; // length of the scale
const LOWEST_TOP = -2; // smallest upper end, as a power of ten
const FALL_AFTER = 3000; // ms

class LogScale {
  constructor() {
    this.top = LOWEST_TOP;
    this.reached = 0; // time when the values last reached the upper decade, ms
  }

  // Include the largest of the current values.
  /** @type {(largest: number, now: number) => void} */
  include(largest, now) {
    const needed = largest > 0 ? Math.max(LOWEST_TOP, Math.ceil(Math.log10(largest))) : LOWEST_TOP;
    if (needed >= this.top) [this.top, this.reached] = [needed, now];
    else if (now - this.reached > FALL_AFTER) [this.top, this.reached] = [this.top - 1, now];
  }

  get bottom() {
    return this.top - DECADES;
  }

  // Place of a value on the scale, from 0 to 1.
  /** @type {(value: number) => number} */
  share(value) {
    return value > 0 ? Math.min(Math.max((Math.log10(value) - this.bottom) / DECADES, 0), 1) : 0;
  }
}

// The scales of the forces, torques and impulses of a scene.
class Scales {
  constructor() {
    this.force = new LogScale();
    this.torque = new LogScale();
    this.impulse = new LogScale();
  }

  /** @type {(moment: LiveMoment, now: number) => void} */
  include({ joints, contacts }, now) {
    for (const kind of EFFORTS) this[kind].include(largestOf(effortsOf(joints, kind)), now);
    let largest = 0;
    for (let k = CONTACT_SIZE - 1; k < contacts.length; k += CONTACT_SIZE) {
      if (contacts[k] > largest) largest = contacts[k];
    }
    this.impulse.include(largest, now);
  }
}

// The largest of numbers that may be NaN; 0 if there are none.
/** @type {(numbers: Iterable<number>) => number} */
const largestOf = (numbers) =>
  Array.from(numbers).reduce((largest, each) => (each > largest ? each : largest), 0);

// A power of ten as text: 0.01, 1, 10, 10 k.
/** @type {(power: number) => string} */
function powerText(power) {
  if (power >= 6 || power < -2) return `10${superscript(power)}`;
  if (power >= 3) return `${10 ** (power - 3)} k`;
  return power >= 0 ? String(10 ** power) : (10 ** power).toFixed(-power);
}

/** @type {(number: number) => string} */
const superscript = (number) =>
  [...String(number)].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(digit)] ?? "⁻").join("");

const LEGEND_LEFT = 14; // pixels: distance of the legend from the left side
const LEGEND_BOTTOM = 14; // pixels: from the lower side
const LEGEND_WIDTH = 168; // pixels
const LEGEND_HEIGHT = 9; // pixels
const LEGEND_ROOM = 50; // pixels: height of a legend with its texts
const BAR_LONGEST = 110; // pixels: longest scale bar

// The legends of forces and torques, and the scale bar above them.
/** @type {(painter: Painter, picture: LivePicture) => void} */
function drawScales(painter, { show, joints, scales }) {
  const kinds = EFFORTS.filter((kind) => show.forces && effortsOf(joints, kind).length > 0);
  kinds.forEach((kind, k) => drawLegend(painter, kind, scales[kind], k * LEGEND_ROOM));
  drawScaleBar(painter, kinds.length * LEGEND_ROOM);
}

/** @type {(painter: Painter, kind: Kind, scale: LogScale, above: number) => void} */
function drawLegend(painter, kind, scale, above) {
  const { context, view, colours, model } = painter;
  const top = view.height - LEGEND_BOTTOM - LEGEND_HEIGHT - 16 - above;
  const strip = context.createLinearGradient(LEGEND_LEFT, 0, LEGEND_LEFT + LEGEND_WIDTH, 0);
  RAMP.forEach((colour, k) => strip.addColorStop(k / (RAMP.length - 1), colour));
  context.fillStyle = strip;
  context.strokeStyle = colours.text;
  context.lineWidth = 1;
  context.fillRect(LEGEND_LEFT, top, LEGEND_WIDTH, LEGEND_HEIGHT);
  context.strokeRect(LEGEND_LEFT, top, LEGEND_WIDTH, LEGEND_HEIGHT);
  painter.setFont("11px", "left", "alphabetic");
  painter.drawText(
    localized(EFFORT_TEXTS[kind], { unit: model.unitOf[kind] }),
    LEGEND_LEFT,
    top - 6,
  );
  /** @type {CanvasTextAlign[]} */
  const aligns = ["left", "center", "right"];
  aligns.forEach((align, k) => {
    context.textAlign = align;
    const text = powerText(scale.bottom + (k * DECADES) / 2);
    painter.drawText(text, LEGEND_LEFT + (k * LEGEND_WIDTH) / 2, top + LEGEND_HEIGHT + 13);
  });
}

// A length of 1, 2 or 5 times a power of ten m, and a line of that length.
/** @type {(painter: Painter, above: number) => void} */
function drawScaleBar(painter, above) {
  const { context, view, colours } = painter;
  const length = Number((1 / roundUp(view.scale / BAR_LONGEST)).toPrecision(1));
  const y = view.height - LEGEND_BOTTOM - above;
  const right = LEGEND_LEFT + length * view.scale;
  const path = new Path2D();
  /** @type {Point[]} */
  const corners = [
    [LEGEND_LEFT, y - 5],
    [LEGEND_LEFT, y],
    [right, y],
    [right, y - 5],
  ];
  for (const corner of corners) path.lineTo(...corner);
  strokeTwice(context, path, colours.background, colours.text, 1.5);
  painter.setFont("11px", "left", "alphabetic");
  painter.drawText(roundLength(length, painter.model.units), right + 6, y);
}
