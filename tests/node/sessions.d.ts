// Types of what the scripts of the live page share, beside their own classes.

type Kind = "force" | "torque";
type Message = { do: string } & Record<string, unknown>;
type Send = (message: Message) => void;

interface Parameter {
  name: string;
  label?: string;
  unit: string;
  low: number;
  high: number;
  value: number;
  logarithmic: boolean;
  whole: boolean;
  rebuilds: boolean;
}

interface LiveDragon extends BenchSizes {
  lengths: number[];
  widths: number[];
  spacings: number[];
  curve: number[];
  curve_error: number;
  hole: number;
}

/** What the server says of a scene. */
interface LiveScene {
  name: string;
  title: string;
  text: string;
  lesson: string;
  generation: number;
  role: string;
  dragon: LiveDragon | null;
  view: Field;
  follows: boolean;
  y_down: boolean;
  units: string;
  unit_of: Record<Kind | "impulse", string>;
  parameters: Parameter[];
  plots: [string, string][];
  buttons: string[];
  keys: string[];
  clicks: boolean;
  scenes: { name: string; title: string }[];
  step: number;
  given: boolean;
  replays: boolean;
  resets: boolean;
  show: string[];
}

interface Obstacle {
  id?: number;
  shape: string;
  x: number;
  y: number;
  size: number;
}

interface LiveState {
  generation: number;
  running: boolean;
  replaying: boolean;
  speed: number;
  contacts: string;
  clients: number;
  values: Record<string, number>;
  cuts: number[];
  obstacles: Obstacle[];
  free_from: number | null;
}

interface LiveEvent {
  time: number;
  text: string;
}

interface LiveError {
  text: string;
  place?: string;
  trace?: string;
}

/** What Pymunk draws. */
interface Shape {
  kind: string;
  points: Point[];
  radius: number;
}

interface Call extends Shape {
  angle: number;
  /** Distance from the first point within which all of it is. */
  reach: number;
  fill: string;
  outline?: string;
  opaque: boolean;
  grip: number;
  /** Its points in the last picture, pixels. */
  screen?: Point[];
}

/** Shapes in the coordinates of the bodies that own them: rows of `LiveFrame.bodies`. */
interface ShapesFrame {
  calls: Float64Array;
  colours?: number[][];
  owners: Float64Array;
}

interface LiveFrame {
  generation: number;
  time: number;
  /** The point that the view follows. */
  focus?: Point | null;
  clock: number;
  step: number;
  step_time: number;
  march_time: number;
  waits: boolean;
  held: [number, number, number, number] | null;
  touching: number[];
  sizes: Record<string, number>;
  colours?: number[][];
  /** Those of all arrays. */
  numbers: Float64Array;
  poses: Float64Array;
  exact: Float64Array;
  errors: Float64Array;
  forces: Float64Array;
  contacts: Float64Array;
  joints: Float64Array;
  /** Poses of the space and of its bodies. */
  bodies: Float64Array;
  shapes: ShapesFrame;
  calls: Call[];
  texts?: DrawnText[];
}

/** A text that a program draws: x, y, the text, its size in pixels; red, green, blue, alpha. */
type DrawnText = [number, number, string, number, [number, number, number, number] | null];

interface Effort {
  number: number;
  effort: number;
  kind: Kind;
}

interface Joint extends Effort {
  ends: [Point, Point];
}

interface Scale {
  step: number;
  valueAt(position: number): number;
  positionOf(value: number): number;
}

interface Held {
  anchor: Point;
  target: Point;
}

/** What a click would change. */
interface Target {
  bench?: number;
  joint?: Joint;
  call?: Call;
  point?: Numbers;
  obstacle?: Obstacle;
  removes?: boolean;
  label?: string;
  pixel?: Point;
}

/** What takes the messages of a connection, and whether it is open. */
interface Listeners {
  received(message: any): void;
  framed(buffer: ArrayBuffer): void;
  changed(open: boolean): void;
  loaded(loading: Loading): void;
}

/** What a published page says of itself and for its worker. */
interface Site {
  title?: string;
  text?: string;
  picture: string;
  lessons?: string;
  wheels?: string[];
  scene?: string;
}

/** How far the worker of a published page is. */
interface Loading {
  stage?: any;
  failure?: LiveError;
}

/** What a widget or a worker posts. */
interface Posted {
  text?: string;
  bytes?: ArrayBuffer;
  frame?: number;
  closed?: boolean;
}

/** A WebSocket, or what a notebook's widget has in its place. */
interface Socket {
  readyState: number;
  binaryType?: string;
  onopen: any;
  onmessage: any;
  onclose: any;
  send(content: any): void;
  close(): void;
}
