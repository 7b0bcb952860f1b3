// Types of what the scripts of pages share, beside their own classes.

type Point = [number, number];
/** Numbers of which the first are x and y, or the components of a vector. */
type Numbers = readonly number[];
type Limits = [number, number];
type Pair = readonly [number, number];

interface Field {
  centre: Numbers;
  size: Numbers;
}

interface Poses {
  x: number[];
  y: number[];
  angle: number[];
  cos: number[];
  sin: number[];
}

interface Rates {
  vx: number[];
  vy: number[];
  angularRate: number[];
}

interface BenchSizes {
  benches: number;
  lengths: ArrayLike<number>;
  widths: ArrayLike<number>;
  spacings: ArrayLike<number>;
}

/** What view and painter need of a dragon or of a scene; lengths in m or in the scene's units. */
interface DrawnModel extends BenchSizes, Subject {
  widths: ArrayLike<number>;
  hole: number;
  /** x0, y0, x1, y1, ... */
  curve: ArrayLike<number>;
  curveError: number;
  grid: Grid | null;
  nearMisses: NearMiss[];
  units: string;
  unitOf: Record<Kind | "impulse", string>;
}

/** A view or a pane: coordinates of its own on a canvas. */
interface Plane {
  toScreen(x: number, y: number): Point;
  toWorld(px: number, py: number): Point;
}

/** Exact benches, and the errors below which they are not drawn; all are without them. */
interface Ghosts {
  benches: Benches<DrawnModel>;
  errors: ArrayLike<number> | null;
}

/** What a source of pictures has at a time. */
interface Moment<M extends DrawnModel = DrawnModel, P extends Poses = Poses> {
  time: number;
  benches: Benches<M, P>;
  inContact: Set<number>;
  /** The first bench whose dancers let go. */
  freeFrom: number | null;
}

interface RecordedMoment extends Moment<Recording, Poses & Rates> {
  /** Pairs of benches in contact. */
  pairs: Pair[];
}

interface LiveMoment extends Moment {
  calls: Call[];
  texts: DrawnText[];
  joints: Joint[];
  cuts: number[];
  /** Points, normals and impulses of contacts. */
  contacts: Float64Array;
}

/** What a painter draws: a moment, and what the stage adds to it. */
interface Picture extends Moment {
  show: Record<string, boolean>;
  /** The bench that is highlighted. */
  pointed: number | null;
  ghosts: Ghosts | null;
}

interface RunPicture extends Picture {
  pairs: Pair[];
  /** Of the handles. */
  velocities: Point[] | null;
}

interface LivePicture extends Picture, LiveMoment {
  scales: Scales;
  held: Held | null;
  target: Target | null;
  /** Whether keys have the canvas, and a cross shows where they act. */
  aims: boolean;
}

/** Draws a part of a picture; the numbers are those of the benches in view. */
type Layer<P extends Picture> = (painter: Painter, picture: P, visible: number[]) => void;

/** What those who extend it add. */
interface Surface {
  tick(now: number): void;
}

interface Gap {
  gap: number;
  ends: Point[];
}

interface NearestBench extends Gap {
  bench: number;
}

interface Grid {
  cell: number;
  origin: Numbers;
}

interface NearMiss {
  time: number;
  benches: Pair;
  gap: number;
}

interface ContactWindow {
  begin: number;
  end: number | null;
  benches: Pair;
}

interface RunEvent {
  time: number;
  end: number;
  kind: string;
  readonly text: string;
}

interface Payload {
  dragon: {
    benches: number;
    hole: number;
    head_spacing: number;
    body_spacing: number | number[];
    overhang: number | number[];
    width: number | number[];
  };
  times: number[];
  errors: [number, number];
  windows: ContactWindow[];
  near_misses: NearMiss[];
  grid: Grid | null;
  curve_error: number;
  [packed: string]: any;
}

/** Numbers that data.py packs, and what unpacking makes of them. */
interface Packing {
  frames: number;
  points: number;
  origin: Numbers;
  step: number;
  order: number;
}

interface Packed {
  frames: number;
  points: number;
  origin: Numbers;
  step: number;
  counts: Int32Array;
}

interface FrameMotion extends Rates {
  x: number[];
  y: number[];
  angle: number[];
}

/** Pose of a bench and its rates of change. */
interface BenchMotion {
  x: number;
  y: number;
  angle: number;
  vx: number;
  vy: number;
  angularRate: number;
}

interface Subject {
  field: Field;
  widths: ArrayLike<number>;
  narrowest: number;
  up?: number;
  free?: boolean;
}

/** Settings of a link; those that are missing or invalid are undefined. */
interface Link {
  time?: number;
  follow?: string;
  at?: Point;
  span?: number;
  show?: string[];
  bench?: number;
  rate?: number;
  slow: boolean;
  plays: boolean;
}

type Colours = Record<string, string>;
type Texts = Record<string, string>;
type Values = Record<string, any>;

interface Look {
  colours: Colours;
  font: string;
}

interface BenchNumbers {
  bench: number;
  part: string;
  velocity: Point | null;
  speed: number | null;
  angle: number;
  gap: number | null;
  nearest: number | null;
  error: number | null;
}

/** Writes a value at an axis. */
type Tick = (value: number) => string;

interface ChartAxes {
  across: Numbers;
  up: Numbers;
  name?: string;
  tick?: Tick;
  tickAcross?: Tick;
  apart?: number;
  apartAcross?: number;
  margins?: { left: number; right: number; above: number; below: number };
}

interface Pointers {
  moved(how: string): void;
  hovered(pixel: Point | null): void;
  tapped(pixel: Point, kind: string): void;
  taken?(pixel: Point, kind: string): boolean;
  carried?(pixel: Point): void;
  dropped?(): void;
}

/** What wheel and pinch zoom around a pixel, and move by pixels. */
interface Zoomed {
  zoom(factor: number, px: number, py: number): void;
  pan(dx: number, dy: number): void;
}

type Action = (event: Event) => unknown;
type Actions = Record<string, Action>;
type Takes = (event: KeyboardEvent) => boolean;

/** What a page adds to the stage of both. */
interface StageControls {
  buttons: Actions;
  keys: Actions;
  pointers: Partial<Pointers> & Pick<Pointers, "tapped">;
  takes?: Takes;
}

interface Stage {
  readonly playing: boolean;
  afterChange(): void;
  setLanguage(name: string): void;
}

/** Elements that scripts find by their id. */
interface PageElements {
  [id: string]: HTMLElement;
  [show: `show-${string}`]: HTMLInputElement;
  [tool: `tool-${string}`]: HTMLInputElement;
  [chart: `chart-${string}`]: HTMLCanvasElement;
  about: HTMLDialogElement;
  back: HTMLButtonElement;
  "begin-alone": HTMLAnchorElement;
  "begin-picture": HTMLImageElement;
  "begin-play": HTMLButtonElement;
  bench: HTMLInputElement;
  contacts: HTMLSelectElement;
  events: HTMLSelectElement;
  field: HTMLCanvasElement;
  forward: HTMLButtonElement;
  last: HTMLButtonElement;
  lesson: HTMLAnchorElement;
  next: HTMLButtonElement;
  loading: HTMLProgressElement;
  "obstacle-size": HTMLInputElement;
  play: HTMLButtonElement;
  previous: HTMLButtonElement;
  rate: HTMLSelectElement;
  reset: HTMLButtonElement;
  save: HTMLAnchorElement;
  scene: HTMLSelectElement;
  slow: HTMLInputElement;
  speed: HTMLSelectElement;
  strip: HTMLCanvasElement;
  time: HTMLInputElement;
  "timeline-all": HTMLButtonElement;
  "timeline-out": HTMLButtonElement;
}

declare var dragon: Promise<unknown>;
declare var live: unknown;
