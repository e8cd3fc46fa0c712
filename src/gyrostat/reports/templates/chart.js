"use strict";
// Zoom and cursor of charts with curves: drag to zoom, double-click or Escape to go back, arrow keys move the cursor.
(() => {
const NS = "http://www.w3.org/2000/svg";
const all = [...document.querySelectorAll("svg.chart")].filter(svg => svg.querySelector(".plot"));
const make = (parent, name, attributes) => {
  const made = document.createElementNS(NS, name);
  for (const key in attributes) made.setAttribute(key, attributes[key]);
  return parent.appendChild(made);
};
// as axis.number
const number = value => {
  const v = +value.toPrecision(6), size = Math.abs(v), exponential = v.toExponential();
  const isShort = String(size).length > 7 && exponential.length - exponential.includes("+") < String(v).length;
  return (v && (size < 1e-4 || size >= 1e6 || isShort) ? exponential : String(v)).replace("e+", "e").replaceAll("-", "−");
};
// what an axis shows linearly: the value, its logarithm, or one that is linear up to a size (Axis._scaled)
const DECADE = 10 / 9, same = v => v;
const warps = {
  log: [Math.log10, v => 10 ** v],
  linear: t => [v => Math.sign(v) * (Math.abs(v) > t ? DECADE + Math.log10(Math.abs(v) / t) : DECADE * Math.abs(v) / t),
    v => Math.sign(v) * t * (Math.abs(v) > DECADE ? 10 ** (Math.abs(v) - DECADE) : Math.abs(v) / DECADE)],
};
// as axis._CLOCK: steps between dates, s
const CLOCK = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 10800, 21600, 43200];
function ticks(low, high, log, most = 7, linear = 0, since = null) {
  if (linear) {
    const [to, from] = warps.linear(linear), top = Math.max(Math.abs(from(low)), Math.abs(from(high)), linear);
    const decades = Math.ceil(Math.log10(top / linear)), found = [0];
    for (let k = 0; k <= decades; k += 1 + Math.floor(decades / 4)) found.push(linear * 10 ** k, -linear * 10 ** k);
    return found.map(v => [to(v), v]).filter(t => t[0] >= low && t[0] <= high);
  }
  if (log) {
    const first = Math.floor(low), last = Math.ceil(high), steps = last - first > 2 ? [1] : [1, 2, 3, 5, 7];
    const found = [];
    for (let k = first; k <= last; k++) for (const s of steps) found.push([Math.log10(s) + k, s * 10 ** k]);
    return found.filter(t => t[0] >= low - 1e-9 && t[0] <= high + 1e-9);
  }
  const raw = (high - low) / most, power = 10 ** Math.floor(Math.log10(raw));
  let step = [1, 2, 5, 10].map(k => k * power).find(s => s >= raw * (1 - 1e-9));
  if (since && step < 1) step = (CLOCK.find(s => s >= 86400 * raw * (1 - 1e-9)) ?? 86400) / 86400;
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push([k * step, k * step]);
  return found;
}
class Chart {
  constructor(svg) {
    this.svg = svg;
    this.plot = svg.querySelector(".plot");
    this.box = ["x", "y", "width", "height"].map(name => +this.plot.getAttribute(name));
    const {log, logx, linear, rows, columns, since} = this.plot.dataset;
    this.log = log !== undefined;
    this.logx = logx !== undefined;
    this.linear = +(linear ?? 0);
    this.rows = rows?.split("|");
    this.columns = columns?.split("|");
    // as Axis.named; an axis in days since a date
    this.moment = days => new Date(Date.parse(`${since}T00:00Z`) + 1e3 * Math.round(86400 * days)).toISOString();
    this.named = !since ? number : days => (text => text.includes("T00:00:00") ? text.slice(0, 10) : text.slice(5, 19).replace("T", " ").replace(/:00$/, ""))(this.moment(days));
    this.since = since;
    [this.toX, this.fromX] = this.logx ? warps.log : [same, same];
    [this.toY, this.fromY] = this.log ? warps.log : this.linear ? warps.linear(this.linear) : [same, same];
    this.x = this.plot.dataset.x.split(" ").map(Number).map(this.toX);
    this.y = this.plot.dataset.y.split(" ").map(Number).map(this.toY);
    this.view = [0, 0, 1000, 1000];
  }
  // a chart as wide as the page keeps the size of its letters
  fit() {
    const wide = Math.max(440, Math.floor(this.svg.parentElement.clientWidth)), {width, height} = this.svg.viewBox.baseVal;
    if (wide === width) return;
    this.svg.setAttribute("viewBox", `0 0 ${wide} ${height}`);
    const [left, , old] = this.box, more = wide - width;
    this.box[2] = old + more;
    this.plot.setAttribute("width", this.box[2]);
    for (const text of this.svg.querySelectorAll("text.label, text.mark[text-anchor]:not([data-x])"))
      text.setAttribute("x", text.matches(".label") ? left + this.box[2] / 2 : +text.getAttribute("x") + more);
    this.zoom(this.view);
  }
  // value of a place between 0 and 1000, as the axis shows it linearly, and back
  valueX(place) { return this.x[0] + place / 1000 * (this.x[1] - this.x[0]); }
  valueY(place) { return this.y[1] - place / 1000 * (this.y[1] - this.y[0]); }
  place(event) {
    const o = this.svg.getBoundingClientRect(), scale = o.width / this.svg.viewBox.baseVal.width;
    const u = ((event.clientX - o.left) / scale - this.box[0]) / this.box[2];
    const v = ((event.clientY - o.top) / scale - this.box[1]) / this.box[3];
    return [this.view[0] + Math.max(0, Math.min(1, u)) * this.view[2], this.view[1] + Math.max(0, Math.min(1, v)) * this.view[3]];
  }
  curves() {
    return this.kept ||= [...this.plot.querySelectorAll(".line")].map(path => {
      const points = [...path.getAttribute("d").matchAll(/[ML](\S+) ([^ML]+)/g)].map(m => [+m[1], +m[2]]);
      return [path.dataset.name, points, path];
    });
  }
  zoom(view) {
    this.view = view;
    this.plot.setAttribute("viewBox", view.join(" "));
    const axes = this.svg.querySelector(".axes"), [left, top, wide, high] = this.box;
    axes.replaceChildren();
    const across = p => left + (p - view[0]) / view[2] * wide, down = p => top + (p - view[1]) / view[3] * high;
    const toX = v => 1000 * (v - this.x[0]) / (this.x[1] - this.x[0]), toY = v => 1000 * (this.y[1] - v) / (this.y[1] - this.y[0]);
    const most = Math.floor(7 * this.svg.viewBox.baseVal.height / 236), names = this.columns;
    const mostX = Math.max(7, Math.floor(wide / 90)), isLong = names && 7 * Math.max(...names.map(n => n.length)) > wide / names.length;
    const atX = most => ticks(this.valueX(view[0]), this.valueX(view[0] + view[2]), this.logx, most, 0, this.since).map(([at, value]) => [at, this.named(value)]);
    const isTight = list => 7 * Math.max(...list.map(([, text]) => text.length)) > wide / list.length;
    const marks = names ? names.map((name, k) => [k, isLong ? k + 1 : name])
      : isTight(atX(mostX)) ? atX(Math.floor(mostX / 2)) : atX(mostX);
    for (const [at, text] of marks) {
      const x = across(toX(at));
      if (x < left - 1 || x > left + wide + 1) continue;
      make(axes, "path", {d: `M${x} ${top}V${top + high}`});
      make(axes, "text", {class: "x", x, y: top + high + 16}).textContent = text;
    }
    for (const [at, value] of this.rows ? [] : ticks(this.valueY(view[1] + view[3]), this.valueY(view[1]), this.log, most, this.linear)) {
      make(axes, "path", {d: `M${left} ${down(toY(at))}H${left + wide}`});
      make(axes, "text", {class: "y", x: left - 5, y: down(toY(at)) + 4}).textContent = number(value);
    }
    for (const label of this.svg.querySelectorAll("text.mark")) {
      const {x, y} = label.dataset;
      const atX = x && across(toX(this.toX(+x))), atY = y && down(toY(this.toY(+y)));
      const isOut = (at, from, size) => at !== undefined && (at < from - 1 || at > from + size + 1);
      if (x === undefined && y === undefined) continue;
      label.style.display = isOut(atX, left, wide) || isOut(atY, top, high) ? "none" : "";
      if (x) label.setAttribute("x", y ? atX : atX + (label.getAttribute("text-anchor") ? -3 : 3));
      if (y) label.setAttribute("y", Math.max(x ? atY : atY - 3, top + 11));
    }
  }
  cursor(place) {
    this.line ||= make(this.plot, "path", {class: "cursor"});
    this.told ||= (() => { const made = document.createElement("output"); made.className = "told screen"; this.svg.after(made); return made; })();
    this.line.setAttribute("d", place === null ? "" : `M${place} ${this.view[1]}v${this.view[3]}`);
    if (place === null) { this.told.textContent = ""; return; }
    this.at = place;
    const parts = this.curves().map(([name, points]) => {
      if (!points.length) return "";
      let low = 0, high = points.length - 1;
      while (high - low > 1) { const k = (low + high) >> 1; if (points[k][0] <= place) low = k; else high = k; }
      const nearest = place - points[low][0] < points[high][0] - place ? low : high;
      const value = this.valueY(points[nearest][1]);
      if (this.rows) return this.rows[Math.round(value)] ?? "";
      const step = (this.y[1] - this.y[0]) / 2000;
      const text = this.log || this.linear ? this.fromY(value).toPrecision(3) : value.toFixed(Math.max(0, Math.min(9, -Math.floor(Math.log10(step)))));
      return `${name} ${text}`;
    });
    const step = (this.x[1] - this.x[0]) / 2000, at = this.valueX(place);
    const x = this.since ? this.moment(at).slice(0, step > 0.01 ? 10 : step > 1e-4 ? 16 : 19).replace("T", " ") : this.columns ? this.columns[Math.round(at)] ?? "" : this.logx ? this.fromX(at).toPrecision(3) : at.toFixed(Math.max(0, -Math.floor(Math.log10(step))));
    this.told.textContent = `${x} ${this.columns || this.since ? "" : this.svg.dataset.unit ?? "s"}`.trim() + `: ${parts.filter(Boolean).join(", ")}`;
  }
}
const charts = all.map(svg => new Chart(svg));
window.gyrostatCharts = charts;
const wide = charts.filter(chart => chart.svg.closest(".wide"));
const fit = () => wide.forEach(chart => chart.fit());
fit();
addEventListener("resize", fit);
// drag from one place to another; `done` receives both, or one place twice for a click
window.gyrostatDrag = (chart, moved, done) => {
  let from = null;
  chart.svg.addEventListener("pointerdown", event => {
    if (event.button || !event.target.closest(".plot, .axes, svg.chart")) return;
    from = chart.place(event);
    chart.svg.setPointerCapture(event.pointerId);
  });
  chart.svg.addEventListener("pointermove", event => moved(from, chart.place(event), event));
  chart.svg.addEventListener("pointerup", event => {
    if (from) done(from, chart.place(event), event);
    from = null;
  });
  chart.svg.addEventListener("pointercancel", () => { from = null; moved(null, null); });
};
for (const chart of charts.filter(c => c.svg.dataset.group)) {
  const same = charts.filter(c => c.svg.dataset.group === chart.svg.dataset.group);
  const span = (from, to) => same.forEach(c => c.zoom([from, c.view[1], to - from, c.view[3]]));
  const reset = () => same.forEach(c => c.zoom([0, 0, 1000, 1000]));
  let frame = null;
  const clear = () => { if (frame) frame.remove(); frame = null; };
  gyrostatDrag(chart, (from, at) => {
    same.forEach(c => c.cursor(at && at[0]));
    clear();
    if (from && at) {
      const isFlat = Math.abs(at[1] - from[1]) < 0.08 * chart.view[3];
      const [y, high] = isFlat ? [chart.view[1], chart.view[3]] : [Math.min(from[1], at[1]), Math.abs(at[1] - from[1])];
      frame = make(chart.plot, "path", {class: "frame", d: `M${from[0]} ${y}H${at[0]}v${high}H${from[0]}Z`});
    }
  }, (from, to) => {
    clear();
    const wide = Math.abs(to[0] - from[0]), high = Math.abs(to[1] - from[1]);
    if (wide < 0.02 * chart.view[2]) return;
    if (high >= 0.08 * chart.view[3]) chart.view = [chart.view[0], Math.min(from[1], to[1]), chart.view[2], high];
    span(Math.min(from[0], to[0]), Math.max(from[0], to[0]));
  });
  chart.svg.addEventListener("pointerleave", () => same.forEach(c => c.cursor(null)));
  chart.svg.addEventListener("dblclick", reset);
  chart.svg.tabIndex = 0;
  chart.svg.addEventListener("keydown", event => {
    const [x, , wide] = chart.view, at = chart.at ?? x + wide / 2;
    if (event.key === "Escape") reset();
    else if (event.key === "ArrowLeft" || event.key === "ArrowRight") {
      const step = (event.key === "ArrowLeft" ? -1 : 1) * wide / 100;
      same.forEach(c => c.cursor(Math.max(x, Math.min(x + wide, at + step))));
    } else if (event.key === "+" || event.key === "-") {
      const size = Math.min(1000, wide * (event.key === "+" ? 0.5 : 2));
      const first = Math.max(0, Math.min(1000 - size, at - size / 2));
      span(first, first + size);
    } else return;
    event.preventDefault();
  });
}
})();
