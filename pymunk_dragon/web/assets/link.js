// The part of the address after "#": time and view,
// for example #t=409.8&follow=head&show=grid,labels

const LINK_DIGITS = 6; // decimals of times and positions
const SPAN_DIGITS = 4; // significant digits of spans
const RUN_SWITCHES = ["curve", "contacts", "handles", "velocities", "grid", "labels", "exact"];
const SHOWN_OF_RUN = ["curve", "contacts"];

/** @type {(number: number) => string} */
const plain = (number) => String(Number(number.toFixed(LINK_DIGITS)));

/** @type {(player: Player) => string} */
function formatLink({ time, rate, defaultRate, slow, follow, shown, selected, view }) {
  const parts = [`t=${plain(time)}`];
  if (follow === "head") parts.push("follow=head");
  if (!follow) parts.push(`at=${plain(view.x)},${plain(view.y)}`);
  if (follow !== "field") parts.push(`span=${Number(view.span.toPrecision(SPAN_DIGITS))}`);
  const names = RUN_SWITCHES.filter((name) => shown[name]);
  if (names.join() !== SHOWN_OF_RUN.join()) parts.push(`show=${names.join()}`);
  if (selected !== null) parts.push(`bench=${selected}`);
  if (rate !== defaultRate) parts.push(`speed=${rate}`);
  if (!slow) parts.push("slow=off");
  if (language !== DEFAULT_LANGUAGE) parts.push(`lang=${language}`);
  return `#${parts.join("&")}`;
}

// Settings of a link; missing and invalid values are undefined.
/** @type {(hash: string) => Link} */
function parseLink(hash) {
  const query = new URLSearchParams(hash.replace(/^#/, ""));
  /** @type {(text: string | null | undefined) => number | undefined} */
  const number = (text) =>
    text?.trim() && Number.isFinite(Number(text)) ? Number(text) : undefined;
  const [x, y, ...rest] = (query.get("at") ?? "").split(",").map(number);
  const span = number(query.get("span"));
  return {
    time: number(query.get("t")),
    follow: ["head", "field"].find((subject) => subject === query.get("follow")),
    at: x !== undefined && y !== undefined && !rest.length ? [x, y] : undefined,
    span: span && span > 0 ? span : undefined,
    show: query
      .get("show")
      ?.split(",")
      .filter((name) => RUN_SWITCHES.includes(name)),
    bench: number(query.get("bench")),
    rate: number(query.get("speed")),
    slow: query.get("slow") !== "off",
    plays: query.has("play"),
  };
}
