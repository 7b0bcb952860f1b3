// The widget of a notebook: a frame with the page, and what goes between it and Python.

function render({ model, el }) {
  const frame = document.createElement("iframe");
  Object.assign(frame, { srcdoc: model.get("page"), title: "A live session", width: "100%", height: 720 });
  frame.style.border = 0;
  frame.sandbox = "allow-scripts allow-downloads";
  // The picture that remains in the notebook is hidden while the page is there.
  const style = document.createElement("style");
  style.textContent = `.${model.get("still")} { display: none !important; }`;
  const toPage = (content, [view]) => {
    const bytes = view && new Uint8Array(view.buffer, view.byteOffset, view.byteLength).slice().buffer;
    frame.contentWindow?.postMessage({ ...content, bytes }, "*");
  };
  const toPython = ({ source, data }) => source === frame.contentWindow && model.send(data);
  model.on("msg:custom", toPage);
  window.addEventListener("message", toPython);
  el.append(style, frame);
  return () => {
    model.off("msg:custom", toPage);
    window.removeEventListener("message", toPython);
  };
}

export default { render };
