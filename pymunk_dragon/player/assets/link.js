// The part of the address after "#": time and view,
// for example #t=409.8&follow=head&show=grid,labels

const LINK_DIGITS = 6; // decimals of times and positions
const SPAN_DIGITS = 4; // significant digits of spans
const SWITCHES = ["curve", "contacts", "handles", "velocities", "grid", "labels", "exact"];
const SHOWN_BY_DEFAULT = ["curve", "contacts"];

const plain = (number) => String(Number(number.toFixed(LINK_DIGITS)));

function formatLink({ time, rate, defaultRate, slow, follow, shown, selected, view }) {
  const parts = [`t=${plain(time)}`];
  if (follow === "head") parts.push("follow=head");
  if (!follow) parts.push(`at=${plain(view.x)},${plain(view.y)}`);
  if (follow !== "field") parts.push(`span=${Number(view.span.toPrecision(SPAN_DIGITS))}`);
  const names = SWITCHES.filter((name) => shown[name]);
  if (names.join() !== SHOWN_BY_DEFAULT.join()) parts.push(`show=${names.join()}`);
  if (selected !== null) parts.push(`bench=${selected}`);
  if (rate !== defaultRate) parts.push(`speed=${rate}`);
  if (!slow) parts.push("slow=off");
  if (language !== DEFAULT_LANGUAGE) parts.push(`lang=${language}`);
  return `#${parts.join("&")}`;
}

// Settings of a link; missing and invalid values are undefined.
function parseLink(hash) {
  const query = new URLSearchParams(hash.replace(/^#/, ""));
  const number = (text) =>
    text?.trim() && Number.isFinite(Number(text)) ? Number(text) : undefined;
  const at = (query.get("at") ?? "").split(",").map(number);
  const span = number(query.get("span"));
  return {
    time: number(query.get("t")),
    follow: ["head", "field"].find((subject) => subject === query.get("follow")),
    at: at.length === 2 && at.every((value) => value !== undefined) ? at : undefined,
    span: span > 0 ? span : undefined,
    show: query.has("show")
      ? query
          .get("show")
          .split(",")
          .filter((name) => SWITCHES.includes(name))
      : undefined,
    bench: number(query.get("bench")),
    rate: number(query.get("speed")),
    slow: query.get("slow") !== "off",
    plays: query.has("play"),
  };
}
