// Flies the run of the page again when a slider moves.
(async () => {
const panel = document.querySelector(".fly"), $ = name => panel.querySelector(name), text = id => document.getElementById(id).textContent;
// beside the slider that was moved last
let touched = "";
const warn = line => {
  const fault = $(".fault");
  ([...panel.querySelectorAll(".slider")].find(({ dataset }) => dataset.key === touched) ?? $(".choices")).after(fault);
  fault.hidden = !line; fault.textContent = line;
};
const fail = (error, next = "") => { panel.dataset.state = "failed"; warn(`This page cannot fly: ${error?.message ?? error}.${next}`); };
addEventListener("unhandledrejection", event => fail(event.reason));
const [packed, module, buffer] = await Promise.all(["fly-about", "fly-module", "fly-words"].map(unpacked));
const about = JSON.parse(new TextDecoder().decode(packed)), keys = about.keys, width = about.words.own, spread = about.dispersed;
const words = new BigInt64Array(buffer), shared = words.subarray(0, about.words.shared);
const nominal = new Float64Array(buffer, 0, keys.length);
const runAt = k => words.slice(shared.length + k * width, shared.length + (k + 1) * width);
const manyAt = shared.length + about.runs.length * width, short = spread.length + 1;
// --- workers: the first flies the run; all of them the cloud
const address = URL.createObjectURL(new Blob([text("fly-worker")], { type: "text/javascript" })), workers = [];
const worker = () => flightWorker(address, workers, { module, about, shared });
const ask = async (each, message) => { await each.ready; return each.ask(message); };
worker();
// --- values: those that were moved, key -> SI
let moved = new Map(), good = [new Map(), 0];
const index = new Map(keys.map((key, k) => [key, k])), column = new Map(spread.map((k, j) => [keys[k], j]));
let shown = 0;
const real = run => new Float64Array(run.buffer, run.byteOffset, width);
const start = key => column.has(key) ? real(runAt(shown))[column.get(key)] : nominal[index.get(key)];
const value = key => moved.get(key) ?? start(key);
// --- values that simulate refuses, which are not flown
const limits = new Map([...panel.querySelectorAll(".slider")].map(({ dataset }) => [dataset.key, Object.assign(dataset, about.sliders[dataset.key])]));
function outside(key, v) {
  const { least, most, expected } = limits.get(key);
  return v >= +least && v <= +most ? "" : `${key}: found ${plain(v)}, expected ${expected}.`;
}
const together = () => about.coupled.filter(pair => pair.every(key => moved.has(key))).map(([a, b]) => `${a}: found it moved together with ${b}, on which its limits depend, expected one of them: gyrostat simulate checks both.`);
// what is refused of values in any case, before the program looks at their relations
const refusal = of => [...moved.keys()].map(key => outside(key, of(key))).find(Boolean) ?? together()[0] ?? "";
// message of a relation, with its values
const message = (row, of) => { const [places, line] = about.relations[row]; return `${places.map(k => keys[k]).reduce((said, key) => said.replaceAll(`{${key}}`, plain(of(key), 6)), line)}.`; };
const concerned = () => about.relations.map(([places]) => places.some(k => moved.has(keys[k])));
// makes a change of the values, or undoes it and says why
function tried(change, undo) {
  change();
  const line = refusal(value);
  warn(line);
  if (line) undo();
  return !line;
}
function inputs() {
  const values = nominal.slice(), run = runAt(shown);
  for (const [key, v] of moved) if (column.has(key)) real(run)[column.get(key)] = v; else values[index.get(key)] = v;
  return { nominal: values, runs: [run], concerned: concerned() };
}
function many() {
  const { nominal: values, runs: [run] } = inputs();
  const every = [...Array(about.cloud).keys()].map(k => {
    const own = run.slice(), from = words.subarray(manyAt + k * short, manyAt + (k + 1) * short);
    own.set(from.subarray(0, spread.length)); own[width - 1] = from[spread.length];
    for (const [key, v] of moved) if (column.has(key)) real(own)[column.get(key)] += v - start(key);
    return own;
  });
  const of = own => key => column.has(key) ? real(own)[column.get(key)] : values[index.get(key)];
  const lines = every.map(own => refusal(of(own)));
  return { nominal: values, cloud: every.filter((_, k) => !lines[k]), refused: lines.filter(Boolean), of, concerned: concerned() };
}
// --- text
function plain(v, digits = 4) {
  const [shownDigits, power] = v.toExponential(digits - 1).split("e").map(Number);
  if (v === 0 || (power >= -4 && power < digits)) return String(+v.toPrecision(digits));
  return `${shownDigits}e${power < 0 ? "-" : "+"}${String(Math.abs(power)).padStart(2, "0")}`;
}
const told = (v, [, factor, unit]) => Number.isFinite(v) ? `${plain(factor * v)} ${unit}`.trim() : "none";
// --- charts
const degrees = 180 / Math.PI, charts = window.gyrostatCharts.filter(chart => chart.svg.dataset.group === "run").slice(0, 4);
const NS = "http://www.w3.org/2000/svg", mark = (chart, kind, name = "path") => {
  const made = document.createElementNS(NS, name);
  made.setAttribute("class", kind);
  return name === "path" ? chart.plot.insertBefore(made, chart.plot.firstChild) : chart.svg.appendChild(made);
};
for (const chart of charts) {
  chart.lines = [...chart.plot.querySelectorAll(".line")];
  chart.ghosts = chart.lines.map(() => mark(chart, "ghost"));
  chart.svg.querySelectorAll("path.event, text.event").forEach(old => old.remove());
  chart.events = about.events.map(() => mark(chart, "event"));
}
const many_path = mark(charts[0], "many");
charts[0].labels = about.events.map((name, k) => { const made = mark(charts[0], "mark event", "text"); made.textContent = name; made.setAttribute("y", charts[0].box[1] + 11 + 12 * k); return made; });
const end = (about.samples - 1) * about.period;
// the first points with the smallest and the largest value of each of 300 parts
function thin(count, at) {
  const size = Math.max(1, Math.ceil(count / 300)), kept = [], point = (k, v) => kept.push([1000 * k * about.period / end, v]);
  for (let k = 0; k < count; k += size) {
    let low = k, high = k, least = at(k), most = least;
    for (let j = k + 1; j < Math.min(count, k + size); ++j) { const v = at(j); if (v < least) { low = j; least = v; } if (v > most) { high = j; most = v; } }
    if (low < high) { point(low, least); point(high, most); } else { point(high, most); if (low !== high) point(low, least); }
  }
  return kept;
}
function curves({ results, signals }) {
  const count = results[0] ? Math.round(results[1] / about.period) + 1 : about.samples, w = about.signals.wheel_speed[2];
  const { error, rate, wheel_speed: speed, torque } = signals, least = 1e-5, each = (f) => [...Array(w).keys()].map(f);
  return [
    [thin(count, k => Math.max(least, degrees * error[k]))],
    [thin(count, k => Math.max(least, degrees * Math.hypot(rate[3 * k], rate[3 * k + 1], rate[3 * k + 2])))],
    each(j => thin(count, k => speed[w * k + j] * 30 / Math.PI)),
    each(j => thin(count, k => about.torque * torque[w * k + j])),
  ];
}
function path(chart, points, held) {
  const [low, high] = chart.y, scale = 1000 / (high - low);
  let d = "";
  for (const [x, v] of points) {
    const y = 1000 - scale * ((chart.log ? Math.log10(v) : v) - low), to = Math.max(-9e3, Math.min(9e3, y)).toFixed(1);
    d += !d ? `M${x.toFixed(1)} ${to}` : held ? `H${x.toFixed(1)}V${to}` : `L${x.toFixed(1)} ${to}`;
  }
  return d;
}
// whether the axis had to change: it has all curves, and they fill half of it
function fit(chart, every) {
  let low = Infinity, high = -Infinity;
  for (const points of every) for (const [, v] of points) { if (v < low) low = v; if (v > high) high = v; }
  if (chart.log) [low, high] = [Math.log10(low), Math.log10(high)];
  if (!(low <= high)) return false;
  const [a, b] = chart.y;
  if (low >= a && high <= b && high - low >= 0.5 * (b - a)) return false;
  const room = Math.max(0.06 * (high - low), chart.log ? 0.1 : 1e-9 + 0.02 * Math.abs(high));
  chart.y = [low - room, high + room];
  return true;
}
let ghost = null, last = null, cloud = null;
function draw() {
  const now = curves(last);
  charts.forEach((chart, k) => {
    const extra = k === 0 && cloud ? cloud.map(each => [...each.error].map((v, j, all) => [1000 * j / (all.length - 1), Math.max(1e-5, degrees * v)]).filter(p => Number.isFinite(p[1]))) : [];
    const moves = fit(chart, [...now[k], ...ghost[k], ...extra]);
    if (moves) chart.zoom(chart.view);
    chart.lines.forEach((line, j) => line.setAttribute("d", path(chart, now[k][j], k === 3)));
    if (moves || !chart.hasGhosts) chart.ghosts.forEach((line, j) => line.setAttribute("d", path(chart, ghost[k][j], k === 3)));
    chart.hasGhosts = true;
    if (k === 0) many_path.setAttribute("d", extra.map(points => path(chart, points)).join(""));
    chart.kept = null;
    // for the cursor, when it comes
    chart.curves = () => chart.kept ||= now[k].map((points, j) => [chart.lines[j].dataset.name, points.map(([x, v]) => [x, 1000 - 1000 * ((chart.log ? Math.log10(v) : v) - chart.y[0]) / (chart.y[1] - chart.y[0])]), chart.lines[j]]);
    chart.events.forEach((line, j) => line.setAttribute("d", `M${(1000 * value(`event.${about.events[j]}.time`) / end).toFixed(1)} 0V1000`));
  });
  charts[0].labels.forEach((label, j) => { label.dataset.x = value(`event.${about.events[j]}.time`); });
  if (about.events.length) charts[0].zoom(charts[0].view);
  motion();
}
// --- motion
const figure = document.querySelector("figure.motion"), world = figure && JSON.parse(figure.querySelector("script").textContent).world;
function frames({ results, signals }, nominal) {
  const count = results[0] ? Math.round(results[1] / about.period) + 1 : about.samples, w = about.signals.wheel_speed[2];
  const step = Math.max(1, Math.ceil(about.samples / about.frames)), chosen = [];
  for (let k = 0; k < count; k += step) chosen.push(k);
  const row = (name, size) => chosen.map(k => Array.from(signals[name].subarray(size * k, size * k + size)));
  const starts = about.phases.map(([, names]) => names.reduce((sum, key) => sum + value(key), 0));
  const target = signals.target && about.moving ? row("target", 4) : chosen.map(k => {
    let phase = 0;
    starts.forEach((t, j) => { if (t <= k * about.period + 1e-9) phase = j; });
    return about.phases[phase][0];
  });
  const motion = { time: chosen.map(k => k * about.period), attitude: row("attitude", 4), speed: row("wheel_speed", w), target, nominal };
  motion.error = chosen.map(k => degrees * signals.error[k]);
  if (world && signals.mode) motion.world = Object.assign(world, { mode: chosen.map(k => about.modes[signals.mode[k]] ?? world.mode[0]) });
  return motion;
}
let still = null;
function motion() { if (figure?.replaceRun && last.results[1] > 0) figure.replaceRun(frames(last, still)); }
// --- table
const rows = [...document.querySelectorAll(".results tr[data-metric]")];
function table() {
  const of = (k, results) => told(results[2 + k], about.metrics[k]);
  rows.forEach((row, k) => {
    const cells = row.querySelectorAll("td"), now = of(k, last.results), before = of(k, first.results);
    cells[1].textContent = now; cells[1].classList.toggle("changed", now !== before);
    cells[2].textContent = before;
    const sorted = cloud?.map(each => each.results[2 + k]).filter(Number.isFinite).sort((a, b) => a - b);
    cells[3].textContent = sorted?.length ? [0, sorted.length - 1 >> 1, sorted.length - 1].map(j => told(sorted[j], about.metrics[k])).join(" · ") : "";
  });
  const incomplete = last.results[0] !== 0, verdict = document.querySelector(".verdict");
  verdict.textContent = incomplete ? `NOT complete: ends after ${plain(last.results[1], 6)} s` : `complete, ${plain(last.results[1], 6)} s`;
  verdict.className = `verdict ${incomplete ? "invalid" : "good"}`;
}
// --- flights: one at a time, always of the newest values
const wanted = ["error", "rate", "wheel_speed", "torque", "attitude", ...["target", "mode"].filter(name => about.signals[name])];
let busy = false, again = false, first = null;
const isMany = () => $(".cloud")?.checked;
// the values of the last flight again, which the charts show
function back() {
  [moved, shown] = [new Map(good[0]), good[1]];
  $(".run").value = shown; tell(); remember();
}
async function fly() {
  if (busy) { again = true; return; }
  busy = true;
  do {
    again = false;
    panel.dataset.state = "flying";
    try { await flight(); panel.dataset.state = "ready"; } catch (error) {
      if (again) continue;
      fail(error, " Move a slider, or press reset, to try again.");
      if (last) back();
    }
  } while (again);
  busy = false;
}
async function flight() {
  const one = workers[0] ?? worker();
  if (!first) {
    first = (await ask(one, { nominal, runs: [runAt(about.nominal)], wanted })).run; ghost = curves(first);
    still = figure ? frames(first).attitude : null;
  }
  const began = performance.now(), asked = [new Map(moved), shown], answer = await ask(one, { ...inputs(), wanted });
  if (!answer.run) {
    if (again) return;
    warn(message(answer.refused[0], value));
    back();
    again = panel.dataset.picture === "0";
    return;
  }
  good = asked; last = answer.run; cloud = null;
  draw(); table();
  panel.flown = { results: [...last.results], error: last.signals.error, flight: answer.time, picture: performance.now() - began };
  if (!again && isMany()) await flyCloud();
  const { picture, many: whole } = panel.flown;
  $(".speed").textContent = `${picture.toFixed(0)} ms${whole ? `, ${cloud.length} runs ${whole.toFixed(0)} ms` : ""}`;
  panel.dataset.picture = +panel.dataset.picture + 1;
}
async function flyCloud() {
  const began = performance.now(), { nominal: values, cloud: runs, refused, of, concerned } = many(), count = Math.min(8, navigator.hardwareConcurrency || 1);
  while (workers.length < count) worker();
  // whole groups of lanes; a worker that is done takes the next one
  const parts = [...Array(Math.ceil(runs.length / 4)).keys()], answers = [];
  await Promise.all(workers.map(async each => {
    for (let k; (k = parts.shift()) !== undefined;) answers[k] = await ask(each, { nominal: values, cloud: runs.slice(4 * k, 4 * k + 4), concerned });
  })).finally(() => { parts.length = 0; });
  cloud = answers.flatMap(each => each.cloud);
  answers.flatMap(each => each.refused).forEach((row, k) => { if (row >= 0) refused.push(message(row, of(runs[k]))); });
  if (refused.length) warn(`${refused.length} of ${about.cloud} runs left out: ${refused[0]}`);
  if (!again) { draw(); table(); }
  Object.assign(panel.flown, { cloud: cloud.map(each => [...each.results]), many: performance.now() - began });
}
// --- sliders
const sliders = [...panel.querySelectorAll(".slider")].map(label => {
  const [range, box] = label.querySelectorAll("input"), { key } = label.dataset, [factor, low, high] = ["factor", "low", "high"].map(name => +label.dataset[name]);
  const tell = () => {
    const v = value(key);
    range.value = 1000 * (v - low) / (high - low);
    box.value = +(factor * v).toPrecision(6);
    label.classList.toggle("moved", moved.has(key));
  };
  const put = v => { if (v === undefined) moved.delete(key); else moved.set(key, v); };
  const set = v => {
    touched = key;
    const old = moved.get(key), done = tried(() => put(v), () => put(old));
    tell();
    if (done) fly();
  };
  // a rounded value stays between the ends
  range.oninput = () => { set(Math.min(high, Math.max(low, +(factor * (low + (high - low) * range.value / 1000)).toPrecision(4) / factor))); };
  box.onchange = () => { if (box.value !== "" && Number.isFinite(+box.value)) set(+box.value / factor); else tell(); };
  range.onchange = () => remember();
  box.addEventListener("change", () => remember());
  range.ondblclick = () => { set(undefined); remember(); };
  return { key, tell };
});
const known = new Set(sliders.map(each => each.key)), tell = () => sliders.forEach(each => each.tell());
// --- address: #run=2&cloud=1&KEY=VALUE, SI
function remember() {
  const parts = new URLSearchParams();
  if (shown) parts.set("run", about.runs[shown][0]);
  if (isMany()) parts.set("cloud", "1");
  for (const [key, v] of moved) parts.set(key, v);
  history.replaceState(null, "", `#${parts}`);
}
function recall() {
  for (const [key, v] of new URLSearchParams(location.hash.slice(1))) {
    const run = about.runs.findIndex(([name]) => name === v);
    if (key === "run" && run >= 0) { shown = run; $(".run").value = run; }
    if (key === "cloud" && $(".cloud")) $(".cloud").checked = v === "1";
    if (known.has(key) && v !== "" && Number.isFinite(+v)) moved.set(key, +v);
  }
  tried(() => {}, () => moved.clear());
}
$(".run").onchange = event => {
  touched = "";
  const old = shown, done = tried(() => { shown = +event.target.value; }, () => { shown = old; event.target.value = old; });
  tell(); remember();
  if (done) fly();
};
if ($(".cloud")) $(".cloud").onchange = () => { warn(""); fly(); remember(); };
$(".reset").onclick = () => { touched = ""; warn(""); moved.clear(); shown = 0; $(".run").value = 0; tell(); fly(); remember(); };
$(".copy").onclick = async () => { remember(); try { await navigator.clipboard.writeText(location.href); $(".copy").textContent = "link copied"; } catch { prompt("Link with all values", location.href); } };
// --- file of this run
window.gyrostatRunFile = () => {
  const values = Object.fromEntries(spread.map(k => [keys[k], value(keys[k])]));
  for (const [key, v] of moved) values[key] = v;
  // the scenario is a text: some of its numbers are infinite
  return `{"gyrostat": "run", "seed": ${about.seed}, "run": ${about.runs[shown][1]},\n"values": ${JSON.stringify(values, null, 1)},\n"scenario": ${about.scenario}}\n`;
};
$(".file").onclick = event => {
  const link = event.currentTarget, old = link.href;
  if (old.startsWith("blob:")) URL.revokeObjectURL(old);
  link.href = URL.createObjectURL(new Blob([window.gyrostatRunFile()], { type: "application/json" }));
  link.download = `${about.name.replace(/[^\w.-]+/g, "_")}_run.json`;
};
recall(); tell();
await fly();
})();
