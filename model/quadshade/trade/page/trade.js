// The scene that is shown: first table, pictures side by side, error maps.

const NAMES = { flat: "Flat", gouraud: "Gouraud", quadratic: "Quadratic",
  "quadratic-specular": "Quadratic + power", phong: "Phong" };
const PARTS = { none: "whole mesh", "all:1": "in fours", "all:2": "in sixteens" };
const PART_KINDS = { all: "in fours, times ", highlights: "highlights, px ", centre: "centre off, levels " };
const state = { scene: CONTENT.scenes[0], left: null, right: null, errors: false, leftOnly: false, wipe: 36 };

function colour(shading) { return shading in NAMES && shading !== "phong" ? `var(--${shading})` : "var(--other)"; }
function shadingName(name) {
  const [kind, number] = name.split(":");
  return kind === "adaptive" ? `Adaptive, rms ${number}` : NAMES[name] ?? name;
}
function partsName(name) {
  const [kind, number] = name.split(":");
  return PARTS[name] ?? (kind in PART_KINDS ? PART_KINDS[kind] + number : name);
}
function points() { return FILES[state.scene].points; }
function folder() { return state.scene.replace(/[^/]*$/, ""); }
function sceneKey() { return state.scene.split("/")[1]; }
function values(name) { return [...new Set(points().map((point) => point[name]))]; }
function pointDatum(index, name, digits) { return datum(state.scene, ["points", index, name], digits); }

function showScenes() {
  byId("scenes").replaceChildren(...CONTENT.scenes.map((file) => el("button", {
    type: "button", "data-scene": file, "aria-pressed": String(file === state.scene),
    onclick: () => { state.scene = file; state.left = state.right = null; showAll(); },
  }, FILES[file].view.scene)));
}

function showSteps() {
  const file = "data/summary.json", key = sceneKey(), at = (name) => [key, "steps", name];
  const { rows, steps } = FILES[file][key];
  const known = steps.psnr !== null;
  byId("headline").replaceChildren(...(known ? ["Quadratic instead of Gouraud shading: ",
    el("b", {}, datum(file, at("psnr"), 1), " dB"), " nearer to Phong, for ",
    datum(file, at("bytes_per_triangle"), 0), " bytes a triangle",
    ...(steps.lut4 === null ? [""] : [" and ", datum(file, at("lut4"), 0), " LUT4"]),
    " more, still at one pixel a clock."] : ["Error and cost of every choice."]));
  const best = Math.max(...rows.map((row) => points()[row.point].psnr ?? 0));
  const made = rows.map((row) => {
    const point = points()[row.point];
    const width = `width:${(90 * (point.psnr ?? best)) / best}px;background:${colour(point.shading)}`;
    return el("tr", { class: row.name === "Quadratic" ? "best" : null },
      el("td", {}, el("span", { class: "swatch", style: `background:${colour(point.shading)}` }), row.name),
      el("td", {}, pointDatum(row.point, "psnr", 1)), el("td", { class: "word" }, el("i", { class: "bar", style: width })),
      el("td", {}, pointDatum(row.point, "max_error")), el("td", {}, pointDatum(row.point, "bytes_per_triangle", 0)),
      el("td", {}, pointDatum(row.point, "clocks_per_pixel", 3)),
      ...["lut4", "dsp", "bram"].map((cell) => el("td", {}, pointDatum(row.point, cell))));
  });
  made.push(el("tr", { class: "reference" }, el("td", {}, el("span", { class: "swatch" }), "Phong"),
    el("td", {}, "reference"), ...Array.from({ length: 7 }, () => el("td", {}, ""))));
  const headings = ["method", "PSNR, dB", "", "worst, grey levels", "bytes / triangle", "clocks / pixel", "LUT4",
    "multipliers", "block RAM"];
  byId("steps-table").replaceChildren(
    el("thead", {}, el("tr", {}, ...headings.map((heading) => el("th", { scope: "col" }, heading)))),
    el("tbody", {}, ...made));
  const view = ["width", "height"].map((name) => datum(state.scene, ["view", name]));
  const { exponent, camera } = FILES[state.scene].view;
  const notice = FILES[state.scene].notice;
  byId("steps-note").replaceChildren("Against Phong shading of the same triangles, ", view[0], " × ", view[1], " pixels",
    ...(exponent === null ? [""] : [", specular exponent ", datum(state.scene, ["view", "exponent"])]),
    ...(camera ? [", camera ", datum(state.scene, ["view", "camera"])] : [""]), ", ",
    datum(file, [key, "fraction"]), " fraction bits. Bytes are those of the set-up stream, per triangle of the mesh that is seen. ",
    ...(notice ? [el("span", { class: "missing" }, "LUTs are not counted: ", datum(state.scene, ["notice"]))]
      : ["Cells on ", datum(state.scene, ["device"]), ", of the smallest core for the method with a set-up stream of ",
        datum(state.scene, ["generics", "stream_width"]), " bits; a carry cell is two LUT4."]));
}

function choice(list, chosen, name, change) {
  return el("select", { onchange: (event) => change(event.target.value) },
    ...list.map((value) => el("option", { value, selected: String(value) === String(chosen) }, name(value))));
}

function find(shading, fraction, subdivision) {
  return points().findIndex((point) => point.shading === shading && point.subdivision === subdivision
    && point.fraction === Number(fraction));
}

// A side is a point's index and whether its reference is shown instead.
function showSide(side) {
  const { index, phong } = state[side], point = points()[index];
  const set = (changes) => {
    const next = { ...point, ...changes };
    const same = points().findIndex((other) => other.shading === next.shading && other.fraction === Number(next.fraction));
    // What is adaptive divides by itself: there is one point of it, whatever the mesh.
    const found = [find(next.shading, next.fraction, next.subdivision), same, index].find((place) => place >= 0);
    state[side] = changes.shading === "phong" ? { index, phong: true }
      : { index: found, phong: phong && !changes.shading };
    showPictures();
  };
  const shown = phong ? [el("span", {}, "Phong shading: the reference")]
    : point.refused !== null ? [el("span", {}, "refused: "), pointDatum(index, "refused")]
      : [pointDatum(index, "psnr", 1), " dB, worst ", pointDatum(index, "max_error"), " grey levels, ",
        pointDatum(index, "bytes"), " bytes, ", pointDatum(index, "clocks"), " clocks"];
  byId(`${side}-side`).replaceChildren(
    el("div", { class: "row" }, el("b", {}, side === "left" ? "Left" : "Right"),
      choice([...values("shading"), "phong"], phong ? "phong" : point.shading, shadingName, (shading) => set({ shading })),
      choice(values("subdivision"), point.subdivision, partsName, (subdivision) => set({ subdivision })),
      choice(values("fraction"), point.fraction, (bits) => `${bits} bits`, (fraction) => set({ fraction }))),
    el("p", {}, ...shown));
  const image = byId(`picture-${side}`), name = phong ? point.reference : state.errors ? point.error_map : point.picture;
  image.style.visibility = name === null || (phong && state.errors) ? "hidden" : "visible";
  image.src = name === null ? "data:," : folder() + name;
}

function showWipe() {
  const place = state.leftOnly ? 100 : state.wipe;
  byId("wipe").value = state.wipe;
  byId("picture-left").style.clipPath = `inset(0 ${100 - place}% 0 0)`;
  byId("picture-right").style.clipPath = `inset(0 0 0 ${place}%)`;
  byId("handle").style.left = `calc(${place}% - 1px)`;
}

function showPictures() {
  const fraction = Math.max(...values("fraction")), shadings = values("shading");
  const first = (shading) => Math.max(0, find(shading, fraction, values("subdivision")[0]));
  state.left ??= { index: first(shadings.includes("gouraud") ? "gouraud" : shadings[0]), phong: false };
  state.right ??= { index: first(shadings.includes("quadratic") ? "quadratic" : shadings[0]), phong: false };
  const { width, height } = FILES[state.scene].view;
  byId("stage").style.aspectRatio = `${width} / ${height}`;
  byId("flip").setAttribute("aria-pressed", state.leftOnly);
  byId("errors").setAttribute("aria-pressed", state.errors);
  showSide("left");
  showSide("right");
  showWipe();
}

function controlPictures() {
  byId("wipe").addEventListener("input", (event) => { state.wipe = Number(event.target.value); showWipe(); });
  byId("swap").addEventListener("click", () => { [state.left, state.right] = [state.right, state.left]; showPictures(); });
  byId("flip").addEventListener("click", () => { state.leftOnly = !state.leftOnly; showPictures(); });
  byId("errors").addEventListener("click", () => { state.errors = !state.errors; showPictures(); });
  const drag = (event) => {
    if (!event.buttons) return;
    const box = byId("stage").getBoundingClientRect();
    state.wipe = Math.min(100, Math.max(0, (100 * (event.clientX - box.left)) / box.width));
    showWipe();
  };
  byId("stage").addEventListener("pointerdown", drag);
  byId("stage").addEventListener("pointermove", drag);
}

function showMaps() {
  const fractions = values("fraction"), chosen = byId("map-fraction");
  if (!fractions.includes(state.fraction)) state.fraction = Math.max(...fractions);
  chosen.replaceChildren(...fractions.map((bits) => el("option", { value: bits, selected: bits === state.fraction }, bits)));
  byId("heat-full").replaceChildren(datum(state.scene, ["heat_full"]));
  const figures = points().map((point, index) => [point, index]).filter(([point]) => point.fraction === state.fraction)
    .map(([point, index]) => el("figure", {},
      point.error_map === null ? el("div", { class: "missing" }, "refused")
        : el("img", { src: folder() + point.error_map, loading: "lazy", alt: `error of ${point.name}` }),
      el("figcaption", {}, `${shadingName(point.shading)}, ${partsName(point.subdivision)}`, el("br"),
        pointDatum(index, "psnr", 1), " dB, worst ", pointDatum(index, "max_error"))));
  byId("map-grid").replaceChildren(...figures);
}

function controlMaps() {
  byId("map-fraction").addEventListener("change", (event) => { state.fraction = Number(event.target.value); showMaps(); });
}
