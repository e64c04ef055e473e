"use strict";
// Numbers and words with the file and path that they come from, and the tables made of them.

const CONTENT = JSON.parse(document.getElementById("content").textContent);
const FILES = CONTENT.files;

function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === false || value === null) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

function byId(id) { return document.getElementById(id); }

function lookUp(file, path) {
  return path.reduce((value, key) => (value === null || value === undefined ? value : value[key]), FILES[file]);
}

function grouped(text) {
  const [whole, rest] = text.split(".");
  const spaced = whole.length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, "\u2009") : whole;
  return rest === undefined ? spaced : `${spaced}.${rest}`;
}

// Digits after the point; without them whole numbers as they are, others with four digits.
function numberText(value, digits) {
  if (Number.isInteger(value) && digits === undefined) return grouped(String(value));
  if (digits !== undefined) return grouped(value.toFixed(digits));
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) return value.toExponential(2);
  return grouped(size >= 1e4 ? value.toFixed(0) : String(Number(value.toPrecision(4))));
}

// What stands in a file, with where it stands; a dash for what is not known.
function datum(file, path, digits) {
  const value = lookUp(file, path);
  if (value === null || value === undefined) return el("span", { class: "unknown" }, "–");
  const text = typeof value === "number" ? numberText(value, digits)
    : typeof value === "boolean" ? (value ? "yes" : "no") : String(value);
  return el("span", { "data-file": file, "data-path": JSON.stringify(path) }, text);
}

function words(name) { return name.replaceAll("_", " "); }

// Headings stand over their columns: words to the left, numbers to the right.
function table(headings, rows) {
  const isWord = (column) => rows.length > 0 && rows[0].children[column]?.className === "word";
  const head = el("tr", {}, ...headings.map((heading, column) =>
    el("th", { scope: "col", class: isWord(column) ? "word" : null }, heading)));
  return el("div", { class: "scroll" }, el("table", {}, el("thead", {}, head), el("tbody", {}, ...rows)));
}

function isRecord(value) { return value !== null && typeof value === "object" && !Array.isArray(value); }
function isScalar(value) { return value === null || typeof value !== "object"; }

// Any JSON as tables: a list of records, a record of scalars, or whatever they are nested in.
function tablesOf(file, path) {
  const value = lookUp(file, path);
  if (Array.isArray(value) && value.length && value.every(isRecord)) {
    return [recordTable(file, path, value), ...nestedTables(file, path, value)];
  }
  if (isScalar(value)) return [el("p", { class: "note" }, `${words(String(path.at(-1)))}: `, datum(file, path))];
  if (Array.isArray(value) && value.length && value.every(isScalar)) {
    return [table(value.map(() => ""), [el("tr", {}, ...value.map((_, index) => el("td", {}, datum(file, [...path, index]))))])];
  }
  const entries = Object.keys(value).map((key) => (Array.isArray(value) ? Number(key) : key));
  const plain = entries.filter((key) => isScalar(value[key]));
  const parts = [];
  if (plain.length) {
    parts.push(table(["", ""], plain.map((key) => el("tr", {}, el("td", {}, words(String(key))),
      el("td", {}, datum(file, [...path, key]))))));
  }
  for (const key of entries.filter((entry) => !isScalar(value[entry]))) {
    parts.push(el("h3", {}, words(String(key))), ...tablesOf(file, [...path, key]));
  }
  return parts;
}

const LONG = 14;

function isText(records, name) { return records.some((record) => typeof record[name] === "string"); }

function recordTable(file, path, records) {
  const names = [...new Set(records.flatMap(Object.keys))];
  const flat = names.filter((name) => records.every((record) => record[name] === undefined || isScalar(record[name])));
  const rows = records.map((record, index) => el("tr", {}, ...flat.map((name) =>
    el("td", { class: isText(records, name) ? "word" : null }, datum(file, [...path, index, name])))));
  const made = table(flat.map(words), rows);
  return records.length > LONG ? el("details", {}, el("summary", {}, "the table"), made) : made;
}

// What records hold beside scalars, folded away under the record's first word.
function nestedTables(file, path, records) {
  return records.flatMap((record, index) => {
    const inner = Object.keys(record).filter((name) => !isScalar(record[name]));
    const title = Object.keys(record).find((name) => typeof record[name] === "string");
    if (!inner.length) return [];
    const heading = title === undefined ? el("summary", {}, "more") : el("summary", {}, datum(file, [...path, index, title]));
    return [el("details", {}, heading, ...inner.flatMap((name) =>
      [el("h3", {}, words(name)), ...tablesOf(file, [...path, index, name])]))];
  });
}
