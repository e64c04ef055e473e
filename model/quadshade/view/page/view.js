// SPDX-License-Identifier: Apache-2.0
// What the mouse and the keys do to the state, and what the answers show. The server draws; nothing is computed here.
"use strict";

const TURN = 0.5; // degrees a pixel of the mouse
const KEY_TURN = 5;
const KEY_MOVE = 0.05;
const ZOOM_STEP = 1.1;
const LOD_STEPS = 4; // of the slider, for half the triangles
const SIZES = [128, 256, 320, 512, 768, 1024];
const BAUDS = [115200, 230400, 460800, 1000000, 2000000, 3000000, 12000000];
const CLOCKS = [12, 24, 50, 100, 150, 200];
const HEAT = ["#000004", "#57106e", "#bc3754", "#f98e09", "#fcffa4"];

const $ = (id) => document.getElementById(id);
let first = {};
let state = {};
let about = {};
let socket;

function clamp(value, [least, most]) {
  return Math.min(Math.max(value, least), most);
}

function change(values) {
  for (const [name, value] of Object.entries(values)) {
    state[name] = typeof value === "number" ? clamp(value, about.ranges[name]) : value;
  }
  ask();
}

function ask() {
  const changed = Object.entries(state).filter(([name, value]) => value !== first[name]);
  const hash = changed.map(([name, value]) => `${name}=${encodeURIComponent(value)}`).join("&");
  history.replaceState(null, "", `#${hash}`);
  showControls();
  document.body.dataset.measured = false;
  if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(state));
}

function say(text, wrong) {
  $("status").textContent = text;
  $("status").classList.toggle("wrong", Boolean(wrong));
}

// Answers.

function connect() {
  const place = location.pathname.replace(/[^/]*$/, "socket");
  socket = new WebSocket(`ws://${location.host}${place}`);
  socket.binaryType = "arraybuffer";
  socket.onmessage = (event) => (typeof event.data === "string" ? hear(JSON.parse(event.data)) : show(event.data));
  socket.onclose = () => say("quadshade view has ended; start it again and reload this page", true);
}

function hear(message) {
  if (message.about) begin(message);
  if (message.error) say(message.error, true);
  if (message.board) {
    $("board").textContent = `board: ${message.board.text}`;
    $("board").classList.toggle("wrong", !message.board.goes_on);
  }
}

function begin(message) {
  about = message.about;
  first = { ...message.state };
  state = { ...message.state };
  for (const [name, value] of new URLSearchParams(location.hash.slice(1))) {
    if (!(name in first)) continue;
    const kind = typeof first[name];
    state[name] = kind === "number" ? Number(value) : kind === "boolean" ? value === "true" : value;
  }
  $("scene").textContent = about.scene;
  document.title = `${about.scene} · Quadshade`;
  fill("map", about.maps);
  fill("shading", about.words.shading);
  fill("fit", about.words.fit);
  fill("size", [...new Set([...SIZES, state.width])].sort((a, b) => a - b), (size) => `${size} pixels`);
  fill("baud", [...new Set([...BAUDS, state.baud])].sort((a, b) => a - b), (rate) => `${rate.toLocaleString("en")} baud`);
  fill("clock_mhz", [...new Set([...CLOCKS, state.clock_mhz])].sort((a, b) => a - b), (rate) => `${rate} MHz`);
  if (about.board) $("board").textContent = `board: ${about.board}, draws when nothing moves`;
  say(`${about.triangles.toLocaleString("en")} triangles`);
  ask();
}

function fill(id, values, name = (value) => value) {
  $(id).replaceChildren(...values.map((value) => new Option(name(value), value)));
}

function show(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(buffer, 4, length));
  const { figures, state: drawn } = JSON.parse(text);
  const canvas = $("picture");
  canvas.width = drawn.width;
  canvas.height = drawn.height;
  const pixels = new Uint8ClampedArray(buffer, 4 + length);
  canvas.getContext("2d").putImageData(new ImageData(pixels, drawn.width, drawn.height), 0, 0);
  showFigures(figures, drawn);
  document.body.dataset.drawn = JSON.stringify(drawn);
  document.body.dataset.measured = figures.largest_error !== null;
}

function number(value, digits = 0) {
  return value === null || value === undefined
    ? "–"
    : value.toLocaleString("en", { minimumFractionDigits: digits, maximumFractionDigits: digits });
}

function showFigures(figures, drawn) {
  const slower = figures.line_fps !== null && figures.line_fps < figures.core_fps ? "line" : "core";
  const rate = slower === "line" ? figures.line_fps : figures.core_fps;
  const rows = [
    ["triangles sent", number(figures.triangles), "triangles"],
    ...Object.entries(figures.orders).map(([name, count]) => [`… ${name}`, number(count), `order-${name.split(" ")[0]}`]),
    ["bytes of set-up words", number(figures.bytes), "bytes"],
    ["bytes on the line, packed", number(figures.line_bytes), "line_bytes"],
    ["clocks of the core", number(figures.clocks), "clocks"],
    ["largest error, grey levels", number(figures.largest_error), "largest_error"],
    ["root mean square error", number(figures.rms_error, 3), "rms_error"],
    [`frames a second at ${number(drawn.baud)} baud, ${drawn.clock_mhz} MHz`, rate === null ? "–" : number(rate, 1), "fps"],
    ["what bounds them", rate === null ? "–" : `the ${slower}`, "bound"],
    ...(figures.levers ? [["what gave for the frame time", figures.levers, "levers"]] : []),
  ];
  const body = $("figures").tBodies[0];
  body.replaceChildren(
    ...rows.map(([name, value, id]) => {
      const row = document.createElement("tr");
      row.append(document.createElement("td"), document.createElement("td"));
      row.cells[0].textContent = name;
      row.cells[1].textContent = value;
      row.cells[1].id = `figure-${id}`;
      return row;
    })
  );
  $("command").value = figures.command;
  $("notes").textContent = figures.notes.join("; ");
  say(`${about.triangles.toLocaleString("en")} triangles`);
  legend(drawn.map, figures);
}

function legend(map, figures) {
  const item = (colour, text) => {
    const entry = document.createElement("span");
    const patch = document.createElement("i");
    patch.style.background = colour;
    entry.append(patch, text);
    return entry;
  };
  let items = [];
  if (map === "error") {
    const step = about.error_full / (HEAT.length - 1);
    items = HEAT.map((colour, index) => item(colour, `${index * step}${index === HEAT.length - 1 ? " and more grey levels" : ""}`));
  }
  if (map === "orders") {
    const names = ["constant", "linear", "quadratic", "power at the pixel"];
    items = names
      .map((name, index) => [name, `rgb(${about.order_colours[index].join(",")})`])
      .filter(([name]) => name in figures.orders)
      .map(([name, colour]) => item(colour, name));
  }
  $("legend").replaceChildren(...items);
}

function showControls() {
  for (const id of ["map", "shading", "fit", "baud", "clock_mhz", "exponent", "max_error", "frame_ms"]) $(id).value = state[id];
  $("size").value = state.width;
  $("exponent").nextElementSibling.value = state.exponent;
  for (const id of ["max_error", "frame_ms"]) $(id).nextElementSibling.value = state[id] > 0 ? state[id] : "off";
  $("lod").value = state.lod > 0 ? LOD_STEPS * Math.log2(state.lod / about.triangles) : 0;
  $("lod").nextElementSibling.value = state.lod > 0 && state.lod < about.triangles ? state.lod : "all";
  const colours = state.shading === "quadratic";
  $("fit").disabled = !colours || state.max_error > 0 || state.frame_ms > 0;
  $("frame_ms").disabled = !colours || state.fit !== "six-point";
  $("max_error").disabled = $("frame_ms").disabled || state.frame_ms > 0;
  drawBall();
}

// The light's ball.

function drawBall() {
  const canvas = $("ball");
  const context = canvas.getContext("2d");
  const middle = canvas.width / 2;
  const radius = middle - 4;
  const [x, y] = state.light ? [state.light_x, state.light_y] : [-0.333, 0.667];
  const at = [middle + x * radius, middle - y * radius];
  const glow = context.createRadialGradient(...at, 2, ...at, radius * 1.6);
  glow.addColorStop(0, state.light ? "#ffe9a8" : "#dddddd");
  glow.addColorStop(1, "#333844");
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.fillStyle = glow;
  context.beginPath();
  context.arc(middle, middle, radius, 0, 2 * Math.PI);
  context.fill();
  context.fillStyle = "#000";
  context.beginPath();
  context.arc(...at, 4, 0, 2 * Math.PI);
  context.fill();
}

function moveLight(x, y) {
  const length = Math.hypot(x, y);
  const scale = length > 1 ? 1 / length : 1;
  change({ light: true, light_x: x * scale, light_y: y * scale });
}

// Mouse and keys.

function dragging(canvas, act) {
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    canvas.focus();
    act(event, 0, 0);
    event.preventDefault();
  });
  canvas.addEventListener("pointermove", (event) => {
    if (canvas.hasPointerCapture(event.pointerId)) act(event, event.movementX, event.movementY);
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
}

dragging($("picture"), (event, right, down) => {
  if (event.buttons & 2 || event.shiftKey) {
    const side = $("picture").clientWidth / 2 / state.zoom;
    change({ across: state.across + right / side, along: state.along - down / side });
  } else if (right || down) {
    change({ yaw: state.yaw - right * TURN, pitch: state.pitch + down * TURN });
  }
});

dragging($("ball"), (event) => {
  const box = $("ball").getBoundingClientRect();
  moveLight(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
});

$("picture").addEventListener(
  "wheel",
  (event) => {
    event.preventDefault();
    change({ zoom: state.zoom * ZOOM_STEP ** -Math.sign(event.deltaY) });
  },
  { passive: false }
);

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

$("picture").addEventListener("keydown", (event) => {
  const [x, y] = ARROWS[event.key] || [0, 0];
  if (event.key in ARROWS && event.shiftKey) {
    change({ across: state.across + x * KEY_MOVE, along: state.along + y * KEY_MOVE });
  } else if (event.key in ARROWS) {
    change({ yaw: state.yaw - x * KEY_TURN, pitch: state.pitch - y * KEY_TURN });
  } else if (event.key === "+" || event.key === "=") {
    change({ zoom: state.zoom * ZOOM_STEP });
  } else if (event.key === "-") {
    change({ zoom: state.zoom / ZOOM_STEP });
  } else if (event.key === "0") {
    reset();
  } else {
    return;
  }
  event.preventDefault();
});

$("ball").addEventListener("keydown", (event) => {
  if (!(event.key in ARROWS)) return;
  const [x, y] = ARROWS[event.key];
  const [from_x, from_y] = state.light ? [state.light_x, state.light_y] : [-0.333, 0.667];
  moveLight(from_x + x * 0.1, from_y + y * 0.1);
  event.preventDefault();
});

function reset() {
  state = { ...first };
  ask();
}

for (const id of ["map", "shading", "fit"]) $(id).addEventListener("change", () => change({ [id]: $(id).value }));
for (const id of ["baud", "clock_mhz"]) $(id).addEventListener("change", () => change({ [id]: Number($(id).value) }));
for (const id of ["exponent", "max_error", "frame_ms"]) $(id).addEventListener("input", () => change({ [id]: Number($(id).value) }));
$("lod").addEventListener("input", () => {
  const share = 2 ** ($("lod").value / LOD_STEPS);
  change({ lod: share < 1 ? Math.max(4, Math.round(about.triangles * share)) : 0 });
});
$("size").addEventListener("change", () => change({ width: Number($("size").value), height: Number($("size").value) }));
$("default_light").addEventListener("click", () => change({ light: false, light_x: 0, light_y: 0 }));
$("reset").addEventListener("click", reset);
$("copy_command").addEventListener("click", () => copy($("command").value));
$("copy_link").addEventListener("click", () => copy(location.href));

async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    say("copied");
  } catch {
    say("the browser does not let this page copy; select the text instead", true);
  }
}

connect();
