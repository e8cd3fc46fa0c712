// Moves target and momentum of a sky map, and fails and revives wheels.
(async () => {
const panel = document.querySelector(".skyfly"), $ = name => panel.querySelector(name), text = id => document.getElementById(id).textContent;
const fault = line => { $(".fault").hidden = !line; $(".fault").textContent = line; };
addEventListener("unhandledrejection", event => { panel.dataset.state = "failed"; fault(`This map cannot be moved: ${event.reason.message ?? event.reason}`); });
const about = JSON.parse(text("sky-about")), [left, top, across, up] = about.map, DEG = Math.PI / 180;
const { exports } = (await WebAssembly.instantiate(await unpacked("sky-module"), {})).instance;
// --- the compiled functions: words of 64 bits, (words, lanes), with two lanes
const LANES = 2, size = 16 + about.names.length + about.sets[0].edges.length + about.sets[0].points.length;
const own = (exports.__heap_base.value + 15) & ~15, made = own + 8 * LANES * size, free = made + 8 * LANES * size;
const lacking = free + 64 - exports.memory.buffer.byteLength;
if (lacking > 0) exports.memory.grow(Math.ceil(lacking / 65536));
function call(name, ...numbers) {
  const words = new Float64Array(exports.memory.buffer, own, LANES * size);
  numbers.flat().forEach((v, k) => words.fill(v, LANES * k, LANES * (k + 1)));
  exports[name](1n, 1n, free, own, made, free, free, free);
  const results = new Float64Array(exports.memory.buffer, made, LANES * size);
  return k => results[LANES * k];
}
function nearest({ momentum, towards, failed }) {
  const { edges, points } = about.sets[failed], at = call("nearest", about.body, momentum, towards, edges, points);
  return { held: at(0) === 1, away: at(1), direction: [at(2), at(3), at(4)], attitude: [at(5), at(6), at(7), at(8)] };
}
function certificate({ momentum, towards, failed }) {
  const { limits, frozen } = about.sets[failed], at = call("certificate", momentum, towards, limits.map(v => v ?? Infinity), frozen);
  return { rate: at(0), excess: at(1), along: [at(2), at(3), at(4)] };
}
// --- state
const radius = Math.hypot(...about.momentum), start = () => ({ momentum: about.momentum, towards: about.towards, failed: about.failed });
let state = start();
const unit = v => { const n = Math.hypot(...v); return v.map(x => x / n); }, dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const toAngles = ([x, y, z]) => [Math.atan2(y, x), Math.atan2(z, Math.hypot(x, y))];
const toUnit = ([a, b]) => [Math.cos(b) * Math.cos(a), Math.cos(b) * Math.sin(a), Math.sin(b)];
const plain = (v, digits = 4) => String(+v.toPrecision(digits)), list = (v, digits) => v.map(x => plain(Math.abs(x) < 1e-12 ? 0 : x, digits)).join(", ");
// word of a command line as a shell reads it, quoted as by Python's shlex.quote
const quoted = word => /^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", `'"'"'`)}'`;
// --- the map: Mollweide projection, by bisection as Newton's method fails at the poles
function place([longitude, latitude]) {
  const aim = Math.PI * Math.sin(latitude);
  let low = -Math.PI / 2, high = Math.PI / 2;
  for (let k = 0; k < 40; ++k) { const t = (low + high) / 2; if (2 * t + Math.sin(2 * t) < aim) low = t; else high = t; }
  return [left + across * longitude / Math.PI * Math.cos(low), top - up * Math.sin(low)];
}
function sky([x, y]) {
  const h = Math.max(-1, Math.min(1, (top - y) / up)), t = Math.asin(h), c = Math.max(1e-9, Math.cos(t));
  const longitude = Math.max(-Math.PI, Math.min(Math.PI, Math.PI * (x - left) / (across * c)));
  return toUnit([longitude, Math.asin(Math.max(-1, Math.min(1, (2 * t + Math.sin(2 * t)) / Math.PI)))]);
}
const svg = document.querySelector(".skymap svg"), bands = svg.querySelector("path.bands");
svg.querySelectorAll("path.bands").forEach(each => { if (each !== bands) each.remove(); });
const mark = name => svg.querySelector(`[data-mark="${name}"]`);
if (!mark("nearest")) { const ring = mark("target").cloneNode(false); ring.dataset.mark = "nearest"; ring.innerHTML = '<g class="mark"><circle r="6.5" fill="none" stroke="#1f5fa8" stroke-width="2.2"/></g>'; svg.append(ring); }
const ROWS = 240, grid = [...Array(ROWS).keys()].map(row => {
  const t = Math.asin(1 - (2 * row + 1) / ROWS), b = Math.asin((2 * t + Math.sin(2 * t)) / Math.PI), width = across * Math.cos(t);
  return { y: top - up + 2 * up * row / ROWS, width, b };
});
const COLUMNS = 480, turn = [...Array(COLUMNS).keys()].map(k => { const a = 2 * Math.PI * (k + .5) / COLUMNS - Math.PI; return [Math.cos(a), Math.sin(a)]; });
// areas of the bands, which are drawn at least a degree wide
function areas() {
  const set = about.sets[state.failed], axis = unit(state.momentum);
  const limits = [...Array(set.bands).keys()].map(k => set.edges.slice(2 * k, 2 * k + 2)).map(([a, b]) => b - a < DEG ? [(a + b - DEG) / 2, (a + b + DEG) / 2] : [a, b]);
  const cosines = limits.map(([a, b]) => [a <= 0 ? 2 : Math.cos(a), b >= Math.PI ? -2 : Math.cos(b)]);
  let d = "";
  for (const { y, width, b } of grid) {
    const c = Math.cos(b), s = Math.sin(b) * axis[2];
    for (let k = 0, from = -1; k <= COLUMNS; ++k) {
      const v = k < COLUMNS ? c * (turn[k][0] * axis[0] + turn[k][1] * axis[1]) + s : NaN, inside = k < COLUMNS && cosines.some(([high, low]) => v <= high && v >= low);
      if (inside && from < 0) from = k;
      if (!inside && from >= 0) { const at = j => (left + width * (2 * j / COLUMNS - 1)).toFixed(1); d += `M${at(from)} ${y.toFixed(1)}H${at(k)}v${(2 * up / ROWS + .1).toFixed(1)}H${at(from)}Z`; from = -1; }
    }
  }
  return d;
}
// --- everything that follows from the state
const buttons = [...panel.querySelectorAll(".wheels button:not(.reset)")], inputs = [...panel.querySelectorAll("input")];
function show() {
  const set = about.sets[state.failed], answer = set.reason === null ? nearest(state) : null, proof = answer?.held ? null : certificate(state);
  bands.setAttribute("d", areas());
  const put = (name, v) => { const [x, y] = place(toAngles(v)); mark(name)?.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)})`); };
  const axis = unit(state.momentum);
  put("target", state.towards); put("total momentum", axis); put("opposite direction", axis.map(v => -v));
  mark("nearest").style.display = answer ? "" : "none";
  if (answer) put("nearest", answer.direction);
  const verdict = $(".verdict");
  verdict.textContent = set.reason !== null ? `NO attitude is feasible: ${set.reason}.` : answer.held ? "The direction is feasible." : `The direction is NOT feasible: the nearest feasible direction is ${plain(answer.away / DEG)} deg away.`;
  verdict.className = `verdict ${set.reason !== null ? "invalid" : answer.held ? "good" : "warning"}`;
  const rows = [["working wheels", about.names.filter((_, k) => !(state.failed >> k & 1)).join(", ") || "none"], ["feasible share of the sky", `${(100 * set.fraction).toFixed(1)} %`], ["total momentum, inertial", `${list(state.momentum)} N·m·s`]];
  if (answer && !answer.held) rows.push(["nearest direction, inertial", list(answer.direction, 6)], ["attitude there (scalar first)", list(answer.attitude, 9)]);
  if (proof?.rate > 0) rows.push(["lower bound of the body rate, at the target", `${plain(proof.rate / DEG)} deg/s: ${plain(proof.excess)} N·m·s that the wheels cannot absorb along body ${list(proof.along)}`]);
  $(".answer").replaceChildren(...rows.map(row => { const tr = document.createElement("tr"); tr.append(...row.map(entry => { const td = document.createElement("td"); td.textContent = entry; return td; })); return tr; }));
  buttons.forEach((button, k) => button.setAttribute("aria-pressed", state.failed >> k & 1 ? "true" : "false"));
  inputs.forEach((input, k) => { if (input !== document.activeElement) input.value = +(toAngles(input.dataset.of === "target" ? state.towards : state.momentum)[k % 2] / DEG).toFixed(4); });
  const lost = about.names.map((name, k) => [name, k]).filter(([, k]) => state.failed >> k & 1).flatMap(([name, k]) => ["--failed", `${name}=${about.kept[k]}`]);
  const comma = v => v.map(x => +x.toPrecision(15)).join(",");
  const words = ["gyrostat", "feasible", about.spacecraft, ...lost, `--momentum=${comma(state.momentum)}`, `--boresight=${comma(about.body)}`, `--towards=${comma(state.towards)}`, "--out", "feasible"];
  $(".command").textContent = words.map(quoted).join(" ");
  Object.assign(panel, { answer: { ...state, ...answer, ...proof, fraction: set.fraction, reason: set.reason } });
}
function change(part) {
  const before = state;
  state = { ...state, ...part };
  try { show(); fault(""); } catch (error) { state = before; try { show(); } catch { /* as before it was moved */ } fault(`The map cannot be moved there: ${error.message ?? error}`); }
}
const move = (name, v) => change(name === "target" ? { towards: v } : { momentum: v.map(x => radius * x) });
function remember() {
  const parts = new URLSearchParams({ towards: state.towards.join(), momentum: state.momentum.join(), failed: state.failed });
  history.replaceState(null, "", `#${parts}`);
}
function recall() {
  const parts = new URLSearchParams(location.hash.slice(1)), vector = name => { const v = (parts.get(name) ?? "").split(",").map(Number); return v.length === 3 && v.every(Number.isFinite) && Math.hypot(...v) > 0 ? unit(v) : null; };
  const [towards, axis, failed] = [vector("towards"), vector("momentum"), parts.get("failed")];
  if (towards) state.towards = towards;
  if (axis) state.momentum = axis.map(x => radius * x);
  if (failed !== null && about.sets[+failed]) state.failed = +failed;
}
buttons.forEach((button, k) => { button.onclick = () => { change({ failed: state.failed ^ 1 << k }); remember(); }; });
$(".reset").onclick = () => { change(start()); history.replaceState(null, "", "#"); };
inputs.forEach((input, k) => { input.onchange = () => {
  const pair = inputs.slice(k - k % 2, k - k % 2 + 2).map(each => each.value === "" ? NaN : +each.value * DEG);
  if (pair.every(Number.isFinite) && Math.abs(pair[1]) <= 90 * DEG) { move(input.dataset.of, toUnit(pair)); remember(); } else fault("longitude and latitude: expected two numbers in deg, a latitude of -90 to 90.");
}; });
let dragged = null;
const at = event => { const p = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse()); return [p.x, p.y]; };
svg.onpointerdown = event => {
  const p = at(event), gap = v => { const q = place(toAngles(v)); return Math.hypot(p[0] - q[0], p[1] - q[1]); };
  if (((p[0] - left) / across) ** 2 + ((p[1] - top) / up) ** 2 > 1.02) return;
  dragged = gap(state.momentum) < Math.min(30, gap(state.towards)) ? "momentum" : "target";
  svg.setPointerCapture(event.pointerId); move(dragged, sky(p)); event.preventDefault();
};
svg.onpointermove = event => { if (dragged) move(dragged, sky(at(event))); };
svg.onpointerup = svg.onpointercancel = () => { if (dragged) { dragged = null; remember(); } };
recall(); show();
panel.dataset.state = "ready";
})();
