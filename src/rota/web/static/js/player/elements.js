/** Elements of the page, made without markup in text, so that no name can become markup. */

const SVG = "http://www.w3.org/2000/svg";
let made = 0;

/**
 * An element with attributes and children. `on`: listeners by event; `text`: its text.
 * @param {string} tag
 * @param {Record<string, any>} [attributes]
 * @param {...(Node|string|null)} children
 */
export function el(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/** The same for a drawing. */
export function svg(tag, attributes = {}, ...children) {
  return filled(document.createElementNS(SVG, tag), attributes, children);
}

function filled(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "on") for (const [event, act] of Object.entries(value)) node.addEventListener(event, act);
    else if (name === "text") node.textContent = value;
    else if (value === true) node.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) node.setAttribute(name, String(value));
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

/** A name for an element that nothing else on the page has. */
export function freshId(stem) {
  made += 1;
  return `rota-player-${stem}-${made}`;
}

/** A control with its label before it. */
export function labelled(text, control, attributes = {}) {
  control.id ||= freshId("field");
  return el("div", { class: "rota-field", ...attributes }, el("label", { for: control.id, text }), control);
}

/** A box to tick with its label behind it. */
export function ticked(text, checked, act) {
  const box = el("input", { type: "checkbox", checked, on: { change: () => act(box.checked) } });
  box.id = freshId("tick");
  return { box, row: el("div", { class: "rota-tick" }, box, el("label", { for: box.id, text })) };
}

/** A section under a heading that can be folded. */
export function section(title, open, ...children) {
  return el("details", { class: "rota-section", open }, el("summary", {}, el("h3", { text: title })), ...children);
}

/** A table with a caption for those who hear it, and rows of texts or nodes. */
export function table(caption, head, rows) {
  return el(
    "div",
    { class: "rota-table", tabindex: "0", role: "region", "aria-label": caption },
    el(
      "table",
      {},
      el("thead", {}, el("tr", {}, ...head.map((text) => el("th", { scope: "col", text })))),
      el("tbody", {}, ...rows.map((row) => el("tr", {}, ...row.map((cell) => el("td", {}, cell))))),
    ),
  );
}
