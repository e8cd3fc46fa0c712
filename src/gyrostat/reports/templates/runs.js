"use strict";
// Selection of runs in histograms: drag over bars, or click one; Shift keeps the selections of other metrics.
(() => {
const element = document.getElementById("runs");
if (!element) return;
const table = JSON.parse(element.textContent), panel = document.getElementById("selected");
const bytes = Uint8Array.from(atob(table.values), c => c.charCodeAt(0));
const count = bytes.length / 3 / table.columns.length;
const words = new Uint32Array(count * table.columns.length);
for (let k = 0; k < words.length; k++) words[k] = (bytes[3 * k] << 24 | bytes[3 * k + 1] << 16 | bytes[3 * k + 2] << 8) >>> 0;
const floats = new Float32Array(words.buffer), columns = {};
table.columns.forEach((column, k) => columns[column.name] = {...column, values: floats.subarray(k * count, (k + 1) * count)});
const runOf = k => table.runs ? table.runs[k] : k;
const folder = table.folder, MOST = 200;
const bars = gyrostatCharts.filter(c => c.svg.dataset.metric).map(chart => {
  const {metric, scale, bins, drivers} = chart.svg.dataset, [low, high, number] = bins.split(" ").map(Number);
  const values = columns[metric].values;
  // as `_bins` in campaign_charts.py
  const bin = k => Math.min(number - 1, Math.floor((values[k] * scale - low) / (high - low) * number + 1e-6));
  return {chart, metric, scale: +scale, low, high, number, bin, values, drivers: JSON.parse(drivers), path: chart.plot.querySelector(".chosen")};
});
const clouds = gyrostatCharts.filter(c => c.svg.dataset.over).map(chart => {
  const [x, y] = chart.svg.dataset.scales.split(" ").map(Number);
  return {chart, x: columns[chart.svg.dataset.over], y: columns[chart.svg.dataset.of], scales: [x, y], path: chart.plot.querySelector(".picked")};
});
const picked = new Map();  // metric -> first and last bin
const number = value => value !== 0 && (Math.abs(value) < 1e-3 || Math.abs(value) >= 1e6) ? value.toExponential(3) : String(+value.toPrecision(4));
const told = (value, unit) => Number.isNaN(value) ? "none" : number(value) + (unit ? ` ${unit}` : "");
function place(bar, bin) {
  const {chart} = bar, value = bar.low + bin / bar.number * (bar.high - bar.low);
  return 1000 * (value - chart.x[0]) / (chart.x[1] - chart.x[0]);
}
function chosen() {
  const found = [];
  const limits = [...picked].map(([metric, range]) => [bars.find(b => b.metric === metric), range]);
  for (let k = 0; k < count; k++) {
    if (limits.every(([bar, [first, last]]) => { const b = bar.bin(k); return b >= first && b <= last; })) found.push(k);
  }
  return found;
}
function draw() {
  const found = picked.size ? chosen() : [];
  for (const bar of bars) {
    const counts = new Array(bar.number).fill(0);
    for (const k of found) { const b = bar.bin(k); if (b >= 0) counts[b]++; }
    const top = bar.chart.y[1];
    bar.path.setAttribute("d", counts.map((n, b) => n ? `M${place(bar, b)} 1000V${1000 - 1000 * n / top}H${place(bar, b + 1)}V1000Z` : "").join(""));
  }
  for (const cloud of clouds) {
    const c = cloud.chart, across = v => 1000 * (v - c.x[0]) / (c.x[1] - c.x[0]), down = v => 1000 * (c.y[1] - v) / (c.y[1] - c.y[0]);
    cloud.path.setAttribute("d", found.slice(0, 1000).map(k => {
      const x = cloud.x.values[k] * cloud.scales[0], y = cloud.y.values[k] * cloud.scales[1];
      return Number.isNaN(y) ? "" : `M${across(x).toFixed(1)} ${down(y).toFixed(1)}h0`;
    }).join(""));
  }
  list(found);
}
function cell(row, text, kind = "td") {
  const made = row.appendChild(document.createElement(kind));
  if (text instanceof Node) made.append(text); else made.textContent = text;
  return made;
}
function replay(run) {
  if (document.getElementById(`run-${run}`)) {
    const link = document.createElement("a");
    link.href = `#run-${run}`; link.textContent = "open";
    return link;
  }
  const code = document.createElement("code");
  code.textContent = `gyrostat replay ${folder} ${run}`;
  code.title = "click to copy"; code.tabIndex = 0;
  code.onclick = () => navigator.clipboard?.writeText(code.textContent);
  return code;
}
function list(found) {
  panel.hidden = !picked.size;
  document.body.classList.toggle("selecting", picked.size > 0);
  if (!picked.size) return;
  const names = [...picked.keys()], main = bars.find(b => b.metric === names[0]);
  const keys = table.columns.filter(c => !c.metric).map(c => c.name);
  const order = [...main.drivers, ...keys.filter(key => !main.drivers.includes(key))];
  const shown = [...names, ...order].map(name => columns[name]);
  const text = names.map(name => {
    const bar = bars.find(b => b.metric === name), [first, last] = picked.get(name);
    const end = bin => told((bar.low + bin / bar.number * (bar.high - bar.low)) / bar.scale, columns[name].unit);
    return `${name} from ${end(first)} to ${end(last + 1)}`;
  });
  const of = table.runs ? `, of the ${count} runs of ${table.count} whose values this page has` : ` of ${count} runs`;
  panel.querySelector("p").textContent = `${found.length}${of}: ${text.join(" and ")}` + (found.length > MOST ? `; the first ${MOST} are listed` : "");
  found.sort((a, b) => main.values[b] - main.values[a]);
  const head = document.createElement("tr"), body = document.createDocumentFragment();
  ["run", "replay", ...shown.map(c => c.unit ? `${c.name} (${c.unit})` : c.name)].forEach(name => cell(head, name, "th"));
  for (const k of found.slice(0, MOST)) {
    const row = document.createElement("tr");
    cell(row, runOf(k)); cell(row, replay(runOf(k)));
    shown.forEach(c => cell(row, told(c.values[k], "")).className = "number");
    body.append(row);
  }
  panel.querySelector("table").replaceChildren(head, body);
  const lines = [["run", ...shown.map(c => c.unit ? `${c.name} (${c.unit})` : c.name)], ...found.map(k => [runOf(k), ...shown.map(c => +c.values[k].toPrecision(5))])];
  panel.querySelector("a").href = "data:text/csv;charset=utf-8," + encodeURIComponent(lines.map(line => line.join(",")).join("\n"));
}
function select(bar, first, last, keep) {
  if (!keep) picked.clear();
  picked.set(bar.metric, [Math.max(0, Math.min(first, last)), Math.min(bar.number - 1, Math.max(first, last))]);
  draw();
}
for (const bar of bars) {
  const at = p => Math.floor((bar.chart.valueX(p) - bar.low) / (bar.high - bar.low) * bar.number);
  gyrostatDrag(bar.chart, (from, to, event) => { if (from && to) select(bar, at(from[0]), at(to[0]), event.shiftKey); },
    (from, to, event) => {
      if (at(from[0]) === at(to[0]) && (at(from[0]) < 0 || at(from[0]) >= bar.number)) { picked.clear(); draw(); }
      else select(bar, at(from[0]), at(to[0]), event.shiftKey);
    });
}
const clear = () => { picked.clear(); draw(); };
panel.querySelector("button").onclick = clear;
addEventListener("keydown", event => { if (event.key === "Escape") clear(); });
// #select=METRIC:FIRST:LAST selects bins, so that a selection can be kept as a link
function linked() {
  const asked = /#select=([^:]+):(\d+):(\d+)/.exec(decodeURIComponent(location.hash));
  const bar = asked && bars.find(b => b.metric === asked[1]);
  if (bar) select(bar, +asked[2], +asked[3], false);
}
addEventListener("hashchange", linked);
linked();
})();
