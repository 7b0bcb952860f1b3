// The widget of a notebook: a frame with the page, and what goes between it and Python.

/** @param { { model: any, el: HTMLElement }} view */
function render({ model, el }) {
  const frame = document.createElement("iframe");
  Object.assign(frame, { title: "A live session", width: "100%", height: "720" });
  frame.style.border = "0";
  frame.sandbox = "allow-scripts allow-downloads";

  // Without a kernel no page comes, and the picture remains that is hidden while the page is there.
  /** @type {(page: string) => void} */
  const open = (page) => {
    if (frame.srcdoc) return; // That of another view of this widget.
    const style = document.createElement("style");
    style.textContent = `.${model.get("still")} { display: none !important; }`;
    frame.srcdoc = page;
    el.append(style, frame);
  };

  /** @type {(content: any, buffers: DataView[]) => void} */
  const toPage = ({ page, ...content }, [view]) => {
    if (page) {
      open(page);
      return;
    }
    const bytes =
      view && new Uint8Array(view.buffer, view.byteOffset, view.byteLength).slice().buffer;
    frame.contentWindow?.postMessage({ ...content, bytes }, "*");
  };
  /** @type {(event: MessageEvent) => unknown} */
  const toPython = ({ source, data }) =>
    source !== null && source === frame.contentWindow && model.send(data);

  model.on("msg:custom", toPage);
  window.addEventListener("message", toPython);
  model.send("page");
  return () => {
    model.off("msg:custom", toPage);
    window.removeEventListener("message", toPython);
  };
}

export default { render };
