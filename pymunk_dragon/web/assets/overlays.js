// Overlays of a live session: joint forces, contacts, cut joints, the held body and what the tool
// points at.

const SMALLEST_DISC = 2; // pixels: radius at a joint with a small force
const DISC_GROWTH = 4.5; // pixels: a large force adds so much
const SHORTEST_IMPULSE = 8; // pixels: arrow of a small impulse
const LONGEST_IMPULSE = 52; // pixels: arrow of a large one
const LONGEST_OF_MANY = 14; // the same where there are many contacts
const MANY_CONTACTS = 24; // more contacts have dots in place of rings
const MOST_ARROWS = 800; // more contacts have no arrows
const CUT_MARK = 5; // pixels: half the size of the cross at a cut joint

// A disc at each joint with a force, a square at one with a torque: colour and size show it.
/** @type {Layer<LivePicture>} */
function drawEfforts({ context, view, colours }, { joints, scales, show }) {
  if (!show.forces) return;
  /** @type {Map<number, Path2D>} */
  const paths = new Map();
  for (const {
    ends: [one, two],
    effort,
    kind,
  } of joints) {
    const x = (one[0] + two[0]) / 2;
    const y = (one[1] + two[1]) / 2;
    if (!(effort >= 0) || !view.isVisible(x, y, 0)) continue;
    const share = scales[kind].share(effort);
    const shade = Math.round(share * (SHADES - 1));
    const path = paths.get(shade) ?? new Path2D();
    paths.set(shade, path);
    const radius = SMALLEST_DISC + DISC_GROWTH * share;
    const [px, py] = view.toScreen(x, y);
    path.moveTo(px + radius, py);
    if (kind === "torque") path.rect(px - radius, py - radius, 2 * radius, 2 * radius);
    else path.arc(px, py, radius, 0, TURN);
  }
  context.strokeStyle = colours.ink;
  context.lineWidth = 0.75;
  for (const [shade, path] of [...paths].sort(([one], [two]) => one - two)) {
    context.fillStyle = SHADE_COLOURS[shade];
    context.fill(path);
    context.stroke(path);
  }
}

// A ring or dot at each contact point, and an arrow along the normal of each pair.
/** @type {Layer<LivePicture>} */
function drawImpulses(painter, { contacts, scales, show }) {
  if (!show.contacts) return;
  const { context, colours, view, model } = painter;
  const count = contacts.length / CONTACT_SIZE;
  const many = count > MANY_CONTACTS;
  const path = new Path2D();
  /** @type { { impulse: number, px: number, py: number } | null} */
  let largest = null;
  context.fillStyle = COLLISION_COLOUR;
  for (const [x, y, nx, ny, impulse] of rowsOf(contacts, CONTACT_SIZE)) {
    if (!view.isVisible(x, y, 0)) continue;
    const [px, py] = view.toScreen(x, y);
    if (many) context.fillRect(px - 2, py - 2, 4, 4);
    else drawRing(painter, [px, py]);
    if (impulse < 0 || count > MOST_ARROWS) continue;
    const longest = many ? LONGEST_OF_MANY : LONGEST_IMPULSE;
    const length = SHORTEST_IMPULSE + (longest - SHORTEST_IMPULSE) * scales.impulse.share(impulse);
    addArrow(path, [px, py], length * nx, -length * ny * view.up);
    if (impulse > (largest?.impulse ?? 0)) largest = { impulse, px, py };
  }
  strokeTwice(context, path, colours.background, COLLISION_COLOUR, 2);
  if (!largest || many) return;
  const { impulse, px, py } = largest;
  const number = impulse >= 0.001 ? Number(impulse.toPrecision(2)) : "< 0.001";
  drawLabel(painter, `${number} ${model.unitOf.impulse}`, px, py);
}

// A cross at both holes of each cut joint.
/** @type {Layer<LivePicture>} */
function drawCuts({ context, view, colours }, { benches, cuts }) {
  const path = new Path2D();
  for (const joint of cuts) {
    for (const hole of [benches.hole(joint, -1), benches.hole(joint + 1, 1)]) {
      const [px, py] = view.toScreen(...hole);
      path.moveTo(px - CUT_MARK, py - CUT_MARK);
      path.lineTo(px + CUT_MARK, py + CUT_MARK);
      path.moveTo(px - CUT_MARK, py + CUT_MARK);
      path.lineTo(px + CUT_MARK, py - CUT_MARK);
    }
  }
  strokeTwice(context, path, colours.background, colours.contact, 2);
}

// A line from the anchor on the held body to the pointer.
/** @type {Layer<LivePicture>} */
function drawHeld({ context, view, colours }, { held }) {
  if (!held) return;
  const { anchor, target } = held;
  const from = view.toScreen(...anchor);
  const to = view.toScreen(...target);
  const path = new Path2D();
  path.moveTo(...from);
  path.lineTo(...to);
  /** @type {[Point, number][]} */
  const marks = [
    [from, 4],
    [to, 7],
  ];
  for (const [[px, py], radius] of marks) {
    path.moveTo(px + radius, py);
    path.arc(px, py, radius, 0, TURN);
  }
  strokeTwice(context, path, colours.background, colours.text, 2);
}

// A cross at the point where keys apply the tool.
/** @type {Layer<LivePicture>} */
function drawAim({ context, view, colours }, { aims }) {
  if (!aims) return;
  const px = view.width / 2;
  const py = view.height / 2;
  const path = new Path2D();
  for (const [dx, dy] of [
    [1, 0],
    [-1, 0],
    [0, 1],
    [0, -1],
  ]) {
    path.moveTo(px + 4 * dx, py + 4 * dy);
    path.lineTo(px + 14 * dx, py + 14 * dy);
  }
  strokeTwice(context, path, colours.background, colours.text, 2);
}

// What a click would change, and its name. A bench is highlighted where it is drawn.
/** @type {Layer<LivePicture>} */
function drawTarget(painter, { target }) {
  if (!target) return;
  const { context, colours, view } = painter;
  if (target.label && target.pixel) drawLabel(painter, target.label, ...target.pixel);
  if (target.joint) {
    const middle = target.joint.ends.map((end) => view.toScreen(...end));
    drawRing(
      painter,
      [0, 1].map((axis) => (middle[0][axis] + middle[1][axis]) / 2),
    );
  } else if (target.call) {
    strokeTwice(context, shapePath(view, target.call), colours.background, colours.text, 2);
  } else if (target.obstacle) {
    context.setLineDash([5, 4]);
    const colour = target.removes ? colours.contact : colours.text;
    strokeTwice(
      context,
      shapePath(view, obstacleCall(target.obstacle)),
      colours.background,
      colour,
      2,
    );
    context.setLineDash([]);
  }
}
