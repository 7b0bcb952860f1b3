// The part of the address after "#": which moment, seen from where. For example #t=409.8&follow=head&show=grid,labels

// Times and places are written to this many digits after the point, spans to so many digits in all.
const LINK_DIGITS = 6, SPAN_DIGITS = 4;
const SWITCHES = ["curve", "contacts", "handles", "velocities", "grid", "labels"];
const SHOWN_AT_FIRST = ["curve", "contacts"];

const plain = (number) => String(Number(number.toFixed(LINK_DIGITS)));

function linkOf({ time, rate, usualRate, follow, shown, picked, view }) {
  const parts = [`t=${plain(time)}`];
  if (follow === "head") parts.push("follow=head");
  if (!follow) parts.push(`at=${plain(view.x)},${plain(view.y)}`);
  if (follow !== "field") parts.push(`span=${Number(view.span.toPrecision(SPAN_DIGITS))}`);
  const names = SWITCHES.filter((name) => shown[name]);
  if (names.join() !== SHOWN_AT_FIRST.join()) parts.push(`show=${names.join()}`);
  if (picked !== null) parts.push(`bench=${picked}`);
  if (rate !== usualRate) parts.push(`speed=${rate}`);
  return `#${parts.join("&")}`;
}

// What a link asks for; what it does not say, or says in a way that makes no sense, is not there.
function linkRead(hash) {
  const given = new URLSearchParams(hash.replace(/^#/, ""));
  const number = (text) => (text !== null && text.trim() !== "" && Number.isFinite(Number(text)) ? Number(text) : undefined);
  const at = (given.get("at") ?? "").split(",").map(number);
  const span = number(given.get("span"));
  return {
    time: number(given.get("t")),
    follow: ["head", "field"].find((subject) => subject === given.get("follow")),
    at: at.length === 2 && at.every((value) => value !== undefined) ? at : undefined,
    span: span > 0 ? span : undefined,
    show: given.has("show") ? given.get("show").split(",").filter((name) => SWITCHES.includes(name)) : undefined,
    bench: number(given.get("bench")),
    rate: number(given.get("speed")),
    plays: given.has("play"),
  };
}
