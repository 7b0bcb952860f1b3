// What all parts use: elements of the page, and angles.

const TURN = 2 * Math.PI;

const element = (id) => document.getElementById(id);

// Set a text only if it changes: a change costs the browser more than drawing does.
function setText(id, text) {
  if (element(id).textContent !== text) element(id).textContent = text;
}
