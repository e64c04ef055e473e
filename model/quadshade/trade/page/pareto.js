// Error against cost: dots, filters, the front.

const AXES = { bytes: "set-up bytes a frame", clocks: "clocks a frame", lut4: "LUT4 of the core", line: "bytes on the line a frame" };
const ERRORS = { rms: "rms error, grey levels", psnr: "PSNR, dB", max_error: "worst error, grey levels" };
const BOX = { left: 74, right: 940, top: 14, bottom: 404 };
const SHAPES = ["circle", "square", "triangle", "diamond", "cross", "star"];
const plot = { x: "bytes", y: "rms", hidden: { shading: new Set(), subdivision: new Set(), fraction: new Set() } };

function svg(tag, attributes = {}, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

// Costs and errors span decades; decibels are logarithms already.
function scale(list, from, to, logarithmic) {
  const bend = logarithmic ? Math.log10 : (value) => value;
  let [low, high] = [Math.min(...list), Math.max(...list)].map(bend);
  const margin = (high - low || 1) * 0.06;
  [low, high] = [low - margin, high + margin];
  const place = (value) => from + ((bend(value) - low) / (high - low)) * (to - from);
  const back = (value) => (logarithmic ? 10 ** value : value);
  return { place, ticks: ticks(back(low), back(high), logarithmic) };
}

function ticks(low, high, logarithmic) {
  const decades = Math.log10(high / low);
  if (logarithmic && decades > 1) {
    const steps = decades > 2.5 ? [1] : [1, 2, 5], found = [];
    for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power += 1) {
      found.push(...steps.map((step) => step * 10 ** power));
    }
    return found.filter((value) => value >= low && value <= high);
  }
  const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= rough);
  const found = [];
  for (let value = Math.ceil(low / step) * step; value <= high; value += step) found.push(value);
  return found;
}

function mark(shape, x, y, size) {
  const path = {
    circle: `M${x - size},${y}a${size},${size} 0 1,0 ${2 * size},0a${size},${size} 0 1,0 ${-2 * size},0`,
    square: `M${x - size},${y - size}h${2 * size}v${2 * size}h${-2 * size}z`,
    triangle: `M${x},${y - size * 1.2}l${size * 1.2},${size * 2.1}h${-size * 2.4}z`,
    diamond: `M${x},${y - size * 1.4}l${size * 1.2},${size * 1.4}l${-size * 1.2},${size * 1.4}l${-size * 1.2},${-size * 1.4}z`,
    cross: `M${x - size},${y - size / 2.5}h${size * 0.6}v${-size * 0.6}h${size * 0.8}v${size * 0.6}h${size * 0.6}v${size * 0.8}`
      + `h${-size * 0.6}v${size * 0.6}h${-size * 0.8}v${-size * 0.6}h${-size * 0.6}z`,
    star: `M${x},${y - size * 1.4}l${size * 0.5},${size}l${size},${size * 0.4}l${-size},${size * 0.4}l${-size * 0.5},${size}`
      + `l${-size * 0.5},${-size}l${-size},${-size * 0.4}l${size},${-size * 0.4}z`,
  };
  return path[shape];
}

function visiblePoints() {
  return points().map((point, index) => ({ point, index })).filter(({ point }) =>
    Object.entries(plot.hidden).every(([name, hidden]) => !hidden.has(String(point[name])))
    && point[plot.x] !== null && point[plot.y] !== null);
}

// Of the visible points, those that no other visible one beats.
function frontOf(shown) {
  const worse = (one, other) => (plot.y === "psnr" ? one < other : one > other);
  return shown.filter(({ point }) => !shown.some(({ point: other }) =>
    other[plot.x] <= point[plot.x] && !worse(other[plot.y], point[plot.y])
    && (other[plot.x] < point[plot.x] || worse(point[plot.y], other[plot.y]))))
    .sort((one, other) => one.point[plot.x] - other.point[plot.x]);
}

function choosePoint(index) {
  state.left = { index, phong: false };
  showPictures();
  showPlot();
}

function showPlot() {
  const shown = visiblePoints(), drawing = byId("plot");
  drawing.replaceChildren();
  showChosen();
  if (!shown.length) {
    drawing.append(svg("text", { x: 480, y: 210, "text-anchor": "middle" }, "nothing to show: no such data, or all is filtered out"));
    return;
  }
  const x = scale(shown.map(({ point }) => point[plot.x]), BOX.left, BOX.right, plot.x === "bytes");
  const positive = shown.every(({ point }) => point[plot.y] > 0);
  const y = scale(shown.map(({ point }) => point[plot.y]), BOX.bottom, BOX.top, plot.y !== "psnr" && positive);
  for (const value of x.ticks) {
    drawing.append(svg("line", { class: "tick", x1: x.place(value), x2: x.place(value), y1: BOX.top, y2: BOX.bottom }),
      svg("text", { x: x.place(value), y: BOX.bottom + 18, "text-anchor": "middle" }, tickText(value)));
  }
  for (const value of y.ticks) {
    drawing.append(svg("line", { class: "tick", x1: BOX.left, x2: BOX.right, y1: y.place(value), y2: y.place(value) }),
      svg("text", { x: BOX.left - 8, y: y.place(value) + 4, "text-anchor": "end" }, tickText(value)));
  }
  drawing.append(svg("text", { x: (BOX.left + BOX.right) / 2, y: BOX.bottom + 42, "text-anchor": "middle" }, AXES[plot.x]),
    svg("text", { transform: `translate(18 ${(BOX.top + BOX.bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, ERRORS[plot.y]));
  const front = frontOf(shown);
  const steps = front.map(({ point }) => `${x.place(point[plot.x])},${y.place(point[plot.y])}`);
  drawing.append(svg("polyline", { class: "front", points: steps.join(" ") }));
  const subdivisions = values("subdivision"), onFront = new Set(front.map(({ index }) => index));
  for (const { point, index } of shown) {
    const shape = SHAPES[subdivisions.indexOf(point.subdivision) % SHAPES.length];
    const kind = `dot${onFront.has(index) ? " on-front" : ""}${index === state.left.index ? " is-chosen" : ""}`;
    const dot = svg("path", { d: mark(shape, x.place(point[plot.x]), y.place(point[plot.y]), onFront.has(index) ? 6 : 4.5),
      class: kind, "data-index": index, style: `fill:${colour(point.shading)}` }, svg("title", {}, point.name));
    dot.addEventListener("click", () => choosePoint(index));
    drawing.append(dot);
  }
}

function tickText(value) {
  if (value >= 1000) return `${Number((value / 1000).toPrecision(6))} k`;
  return String(Number(value.toPrecision(3)));
}

function showChosen() {
  const index = state.left.index;
  byId("chosen").replaceChildren(el("b", {}, pointDatum(index, "name")), ": rms ", pointDatum(index, "rms", 3), ", PSNR ",
    pointDatum(index, "psnr", 2), " dB, ", pointDatum(index, "triangles"), " triangles, ", pointDatum(index, "bytes"),
    " bytes, ", pointDatum(index, "clocks"), " clocks, ", pointDatum(index, "lut4"), " LUT4, ", pointDatum(index, "dsp"), " multipliers, ",
    pointDatum(index, "bram"), " block RAM, word of ",
    pointDatum(index, "word_width"), " bits");
}

function showFilters() {
  const titles = { shading: "Shading", subdivision: "Mesh", fraction: "Fraction bits" };
  const subdivisions = values("subdivision");
  const icon = (name, value) => {
    const shape = name === "subdivision" ? SHAPES[subdivisions.indexOf(value) % SHAPES.length] : "circle";
    const fill = name === "shading" ? colour(value) : "var(--soft)";
    return svg("svg", { width: 14, height: 14 }, svg("path", { d: mark(shape, 7, 7, 4.2), style: `fill:${fill}` }));
  };
  byId("filters").replaceChildren(...Object.keys(titles).map((name) => el("fieldset", {}, el("legend", {}, titles[name]),
    ...values(name).map((value) => el("label", {},
      el("input", { type: "checkbox", "data-filter": name, value, checked: !plot.hidden[name].has(String(value)),
        onchange: (event) => { plot.hidden[name][event.target.checked ? "delete" : "add"](String(value)); showPlot(); } }),
      ...(name === "fraction" ? [""] : [icon(name, value)]),
      name === "shading" ? shadingName(value) : name === "subdivision" ? partsName(value) : String(value))))));
}

function controlPlot() {
  for (const [axis, names] of [["x", AXES], ["y", ERRORS]]) {
    byId(`axis-${axis}`).append(...Object.entries(names).map(([value, name]) => el("option", { value }, name)));
    byId(`axis-${axis}`).addEventListener("change", (event) => { plot[axis] = event.target.value; showPlot(); });
  }
}
