// Draws the newest frame.

const PALE = 0.55; // weight of the background in the colour of benches whose dancers let go

// What the first message of the server replaces.
const NOTHING_YET = /** @type {any} */ (null);
const NO_PAYLOAD = /** @type {any} */ ({});

/** @extends {Painter<Model>} */
class LivePainter extends Painter {
  /** @param {HTMLCanvasElement} canvas @param {View} view */
  constructor(canvas, view) {
    super(canvas, NOTHING_YET, view, NO_PAYLOAD, []);
    /** @type {Model} */
    this.model = NOTHING_YET;
    this.pale = false;
    this.scales = { force: new LogScale(), torque: new LogScale() };
    this.impulseScale = new LogScale();
  }

  /** @type {(model: Model) => void} */
  setModel(model) {
    const { dragon } = model.scene;
    this.model = model;
    this.motion = model;
    this.payload = /** @type {any} */ ({ dragon });
    this.curve = dragon?.curve ?? [];
    this.curveError = Math.max(dragon?.curve_error ?? 0, Number.EPSILON);
    this.scales = { force: new LogScale(), torque: new LogScale() };
    this.impulseScale = new LogScale();
  }

  /** @type {(i: number, inContact: Set<number>) => string} */
  colourOf(i, inContact) {
    const colour = super.colourOf(i, inContact);
    return this.pale ? mixed(colour, this.colours.background, PALE) : colour;
  }

  // Draw a frame: `state` is the server's, `show` the switches,
  // `held` and `target` belong to the pointer.
  /** @type {(shown: Shown) => void} */
  draw({ frame, poses, state, show, held, target, aims }) {
    const { model } = this;
    const joints = model.joints(frame, poses, state.cuts);
    const benches = new Benches(model, poses);
    const visible = this.visible(benches);
    const inContact = new Set(frame.touching);
    const now = performance.now();
    for (const kind of EFFORTS) this.scales[kind].include(largestOf(effortsOf(joints, kind)), now);
    this.impulseScale.include(
      largestOf(frame.contacts.filter((_, k) => k % CONTACT_SIZE === CONTACT_SIZE - 1)),
      now,
    );
    this.clear();
    if (show.curve && model.benches) this.drawCurve();
    if (model.benches) {
      drawCalls(this, state.obstacles.map(obstacleCall));
      this.drawDragon({ frame, benches, visible, inContact, state, show, target });
    } else drawCalls(this, frame.calls);
    const legends = EFFORTS.filter((kind) => show.forces && effortsOf(joints, kind).length > 0);
    if (show.forces) drawEfforts(this, joints);
    if (show.labels) drawNumbers(this, benches, visible, inContact);
    drawCuts(this, benches, state.cuts);
    if (show.contacts) drawImpulses(this, frame);
    if (held) drawHeld(this, held);
    if (target) drawTarget(this, target);
    if (aims) drawAim(this);
    legends.forEach((kind, k) => drawLegend(this, kind, k * LEGEND_ROOM));
    drawScaleBar(this, legends.length * LEGEND_ROOM);
  }

  /** @type {(shown: ShownDragon) => void} */
  drawDragon({ frame, benches, visible, inContact, state, show, target }) {
    /** @type {(i: number) => boolean} */
    const free = (i) => state.free_from !== null && i >= state.free_from;
    this.pale = true;
    this.drawBenches(benches, visible.filter(free), inContact);
    this.pale = false;
    this.drawBenches(
      benches,
      visible.filter((i) => !free(i)),
      inContact,
    );
    if (target?.bench !== undefined) this.drawPointed(benches, target.bench, inContact);
    if (show.ghost) drawErrors(this, frame);
    if (show.handles) drawHandles(this, benches, visible);
  }
}
