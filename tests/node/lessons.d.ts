// Types of what the scripts of lessons share, beside their own classes.

/** x and y, and those of the unit tangent or of the derivative. */
type Frame = [number, number, number, number];
/** A text in English and in Chinese. */
type Words = readonly [string, string];

interface Curve {
  begin: number;
  end: number;
  frame(s: number): Frame;
  behind?(s: number, chord: number, guess?: number): number;
}

interface TurnArc {
  centre: Point;
  radius: number;
  side: number;
  angle: number;
}

interface DragonSizes {
  benches?: number;
  head?: number;
  body?: number | number[];
  overhang?: number;
  width?: number | number[];
}

interface Dragon extends BenchSizes {
  spacings: number[];
  widths: number[];
  lengths: number[];
}

interface Chain {
  s: number[];
  points: Frame[];
  ratios: number[];
}

interface Filed {
  cells: Map<string, number[]>;
  entries: number;
  pairs: number[][];
}

/** A run of a dragon that only its head pulls, as a page has it. */
interface PulledRun {
  drag: number;
  until: number;
  contact: { time: number; benches: Pair } | null;
  shape: Packing;
  text: string;
}

/** What the lesson on the engine has written; lists by rule and iterations are by the step. */
interface EngineRuns {
  substeps: number[];
  passes: number[];
  errors: Record<string, number[]>;
  moved: Record<string, Point[][][]>;
  exact: Point[][];
}

interface SliderOptions {
  min: number;
  max: number;
  step: number;
  value: number;
  unit?: string;
  digits?: number;
  play?: () => number;
  show?: (value: number) => string;
  moved?: (value: number) => void;
}

/** What a lesson says of a scene that Pymunk plays. */
interface PlayedOptions {
  scene: string;
  changed?: (event: LiveEvent | null) => void;
}

interface KnobOptions {
  pane?: StagePane;
  at: () => Numbers;
  moved: (point: Point, way?: number) => unknown;
  step?: number;
  small?: boolean;
  released?: () => void;
}

/** A slider as a lesson has it. */
interface Slid {
  value: number;
  max: number;
}

/** A slider as the lab has it. */
interface Row {
  label: Words;
  input: HTMLInputElement;
  name: HTMLElement;
  shown: HTMLElement;
  play?: () => number;
  plays: boolean;
  show: (value: number) => string;
  button?: HTMLButtonElement;
  exact: number;
}

interface FloorView {
  x: number;
  y: number;
  size: number;
  wide?: number;
}

interface ChartView {
  across: Limits;
  up: Limits;
  name: Words;
  tick?: (value: number) => string;
  apart?: number;
}

type PaneView = FloorView | ChartView;

interface GapParts {
  time: { value: number };
  size: () => number;
  benchesAt: (t: number, handles?: number) => Benches<BenchSizes>;
  view: () => ChartView;
  draw: (pane: StagePane) => void;
}

interface GapNow extends NearestBench {
  seen: number;
  update(): void;
}

interface Wall {
  shadows: number[][];
  light: number[] | undefined;
  at: (along: number, away?: number) => Point;
}

/** How far the course of a lesson came: its state, the numbers of the choices, and its program. */
interface Course {
  state: string;
  chosen: number[];
  unfolded: boolean;
}

/** Moments of a scene, with the corners of each body. */
type Film = Point[][][];
