/** The page /docs: the OpenAPI document for people, made of /openapi.json. */

const dark = window.matchMedia("(prefers-color-scheme: dark)");

function followTheme() {
  document.body.dataset.theme = dark.matches ? "dark" : "light";
}

function element(name, text, ...children) {
  const made = document.createElement(name);
  if (text !== null) made.textContent = text;
  made.append(...children);
  return made;
}

function schemaText(schema) {
  const shown = element("pre", JSON.stringify(schema, null, 1));
  shown.tabIndex = 0;
  return shown;
}

/** Parameters of the path and the address. */
function parameters(listed) {
  const terms = listed.flatMap((parameter) => {
    const where = parameter.in === "path" ? "in the path" : "in the query";
    const type = parameter.schema.type ?? "";
    return [
      element("dt", parameter.name),
      element("dd", [where, type, parameter.description].filter(Boolean).join(", ")),
    ];
  });
  return [element("h3", "Parameters"), element("dl", null, ...terms)];
}

/** What one kind of answer holds. */
function answer(status, response) {
  const parts = [element("h3", `${status} ${response.description}`)];
  for (const [kind, { schema }] of Object.entries(response.content ?? {})) {
    const name = schema.$ref?.split("/").pop();
    if (name === "Error") continue; // the same for all
    const said = element("p", name ? `${kind}: ` : kind);
    if (name) {
      const link = element("a", name);
      link.href = `#schema-${name}`;
      said.append(link);
    }
    parts.push(said, ...(name ? [] : [schemaText(schema)]));
  }
  return parts;
}

function operation(method, path, told) {
  const head = element("summary", null, element("code", `${method.toUpperCase()} ${path}`), ` ${told.summary}`);
  const made = element("details", null, head);
  if (told.parameters) made.append(...parameters(told.parameters));
  for (const [kind, { schema }] of Object.entries(told.requestBody?.content ?? {})) {
    made.append(element("h3", `Body, ${kind}`), schemaText(schema));
  }
  for (const [status, response] of Object.entries(told.responses)) made.append(...answer(status, response));
  return made;
}

function schemas(named) {
  return Object.entries(named).map(([name, schema]) => {
    const made = element("details", null, element("summary", null, element("code", name)), schemaText(schema));
    made.id = `schema-${name}`;
    return made;
  });
}

/** Opens the schema that the address names. */
function openNamed() {
  const named = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (named) {
    named.open = true;
    named.scrollIntoView();
  }
}

async function start() {
  followTheme();
  dark.addEventListener("change", followTheme);
  const place = document.getElementById("operations");
  try {
    const got = await fetch("/openapi.json");
    const told = await got.json();
    if (!got.ok) throw new Error(told.error.message);
    const bySubject = new Map();
    for (const [path, methods] of Object.entries(told.paths)) {
      for (const [method, one] of Object.entries(methods)) {
        const subject = one.tags[0];
        bySubject.set(subject, [...(bySubject.get(subject) ?? []), operation(method, path, one)]);
      }
    }
    const parts = [...bySubject].flatMap(([subject, made]) => [element("h2", subject), ...made]);
    place.replaceChildren(...parts, element("h2", "schemas"), ...schemas(told.components.schemas));
    openNamed();
    window.addEventListener("hashchange", openNamed);
  } catch (error) {
    place.replaceChildren(element("p", `The document cannot be loaded: ${error.message}`));
  }
}

start();
