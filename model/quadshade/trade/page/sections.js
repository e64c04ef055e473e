// What does not depend on the scene: the papers' tables, the reports, the list of files; then the start.

const TITLES = {
  stability: "Set-up methods at the extremes",
  extremes: "Numbers at the extremes",
  continuity: "Colour across edges",
  adapt: "Spend where it shows",
  density: "More triangles, or a higher order",
  throughput: "Clocks per pixel",
  hostspeed: "Speed of the host",
  demo: "The spheres, through the VHDL",
  cho: "Adaptive shading, in the terms of Cho, Neumann and Woo",
  edges: "Edges of a G-buffer, and styles",
  faults: "Faults on the link",
  boardspeed: "The simulated board",
};

function missing(what, command) {
  return el("p", { class: "missing" }, `No data for “${what}” yet; `, el("code", {}, command), " writes them.");
}

function paperTable(title, note, key, headings, columns) {
  const file = "data/papers.json", path = key.split(".");
  const records = lookUp(file, path);
  const rows = records.map((row, index) => el("tr", {}, ...columns.map(([name, digits]) =>
    el("td", { class: isText(records, name) ? "word" : null }, datum(file, [...path, index, name], digits)))));
  return [el("h3", {}, title), el("p", { class: "note" }, note), table(headings, rows)];
}

function showPapers() {
  const barrera = paperTable("Barrera, Hast and Bengtsson, Table 1: a hundred million set-ups",
    "Seconds on their Pentium 4 of 1.8 GHz, and on one core of the machine that wrote the report of the host’s speed.",
    "barrera", ["method", "paper, s", "ours", "ours, s"], [["method"], ["paper_seconds", 1], ["ours"], ["our_seconds", 2]]);
  const abbas = paperTable("Abbas et al., section 6: time of a pixel",
    "Frames are those of a million pixels, of which the paper promises 16 a second; our clocks are after place-and-route, the median of several seeds.",
    "abbas", ["design", "device", "MHz", "ns / pixel", "frames / s"],
    [["what"], ["device"], ["mhz", 1], ["ns_per_pixel", 2], ["frames_per_second", 0]]);
  const times = paperTable("Cho, Neumann and Woo, Table 1: milliseconds a frame",
    "A teapot of 896 triangles, 60 views, four lights, on their workstation.", "cho.table_1",
    ["method", "256², software", "256², hardware", "512², software", "512², hardware"],
    [["method"], ["software_256_ms"], ["hardware_256_ms"], ["software_512_ms"], ["hardware_512_ms"]]);
  const counts = paperTable("The same, Table 2: triangles", "Final ones, and how many of the first were subdivided.",
    "cho.table_2", ["method", "256², final", "subdivided", "512², final", "subdivided"],
    [["method"], ["final_256", 1], ["subdivided_256", 1], ["final_512", 1], ["subdivided_512", 1]]);
  const beside = [!("data/cho.json" in FILES) ? missing("Cho’s tables, ours", CONTENT.reports.cho)
    : el("p", { class: "note" }, "Ours, in the same terms: ", el("a", { href: "#cho" }, "further down"), ".")];
  const notes = [["hostspeed", "Barrera’s table, ours"], ["resources", "the core’s clock"]]
    .filter(([name]) => !(`data/${name}.json` in FILES))
    .map(([name, what]) => missing(what, CONTENT.reports[name] ?? "make limits"));
  byId("paper-tables").replaceChildren(...barrera, ...abbas, ...times, ...counts, ...beside, ...notes);
}

function showReports() {
  const sections = Object.entries(CONTENT.reports).map(([name, command]) => {
    const file = `data/${name}.json`, title = TITLES[name] ?? words(name), heading = el("h2", {}, title);
    const figures = CONTENT.plots.filter((path) => path.startsWith(`data/${name}`))
      .map((path) => el("img", { class: "figure", src: path, alt: title, loading: "lazy" }));
    const tables = file in FILES ? tablesOf(file, []) : [missing(title, command)];
    return el("section", { id: name }, heading, ...figures, ...tables);
  });
  byId("reports").replaceChildren(...sections);
}

function showFiles() {
  byId("files").replaceChildren(...Object.keys(FILES).map((file) => el("li", {}, el("a", { href: file }, file))));
}

function showAll() {
  showScenes();
  showSteps();
  showPictures();
  showMaps();
  showFilters();
  showPlot();
}

controlPictures();
controlMaps();
controlPlot();
showAll();
showPapers();
showReports();
showFiles();
