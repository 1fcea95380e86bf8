/** Fields of forms, made of what the schema of mission files says of them: title, unit, default and meaning. */

const UNITS = [
  [/_m_s3$/, "m/s³"],
  [/_m_s2$/, "m/s²"],
  [/_m_s$/, "m/s"],
  [/_rad_s$/, "rad/s"],
  [/_m$/, "m"],
  [/_s$/, "s"],
  [/_deg$/, "°"],
  [/_wh$/, "Wh"],
  [/_w$/, "W"],
  [/_percent$/, "%"],
];

/** What a value may be, where it may be null as well. */
export function plain(about) {
  const choice = about.anyOf?.find((option) => option.type !== "null");
  return choice === undefined ? about : { default: about.default, ...choice };
}

/** A field's name in words, and its unit. */
export function worded(name, title = undefined) {
  const unit = UNITS.find(([pattern]) => pattern.test(name));
  const stem = unit === undefined ? name : name.replace(unit[0], "");
  const words = title ?? stem.replaceAll("_", " ");
  return [words.charAt(0).toUpperCase() + words.slice(1), unit === undefined ? "" : unit[1]];
}

/** The numbers among a block's fields, by their names. */
export function numbersOf(properties) {
  return Object.entries(properties).filter(([, about]) => ["number", "integer"].includes(plain(about).type));
}

/**
 * An input for a number.
 * @param {import("./fields.js").Fields} fields
 * @param {(string|number)[]} path of the block
 * @param {string} name
 * @param {any} about what the schema says of it
 * @param {string} placeholder in place of the default
 */
export function numberField(fields, path, name, about, placeholder = "") {
  const [label, unit] = worded(name, about.title);
  const usual = about.default ?? "";
  return fields.number([...path, name], label, { unit, help: about.description ?? "", placeholder: placeholder || String(usual) });
}
