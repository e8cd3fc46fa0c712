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
const number = value => String(+value.toPrecision(6)).replace("-", "−");
function ticks(low, high, log, most = 7) {
  if (log) {
    const first = Math.floor(low), last = Math.ceil(high), steps = last - first > 2 ? [1] : [1, 2, 3, 5, 7];
    const found = [];
    for (let k = first; k <= last; k++) for (const s of steps) found.push([Math.log10(s) + k, s * 10 ** k]);
    return found.filter(t => t[0] >= low - 1e-9 && t[0] <= high + 1e-9);
  }
  const raw = (high - low) / most, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map(k => k * power).find(s => s >= raw * (1 - 1e-9));
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push([k * step, k * step]);
  return found;
}
class Chart {
  constructor(svg) {
    this.svg = svg;
    this.plot = svg.querySelector(".plot");
    this.box = ["x", "y", "width", "height"].map(name => +this.plot.getAttribute(name));
    this.log = "log" in this.plot.dataset;
    this.rows = this.plot.dataset.rows?.split("|");
    this.x = this.plot.dataset.x.split(" ").map(Number);
    this.y = this.plot.dataset.y.split(" ").map(Number).map(v => this.log ? Math.log10(v) : v);
    this.view = [0, 0, 1000, 1000];
  }
  // value of a place between 0 and 1000, and back; y is log10 of the value on a logarithmic axis
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
    const most = Math.floor(7 * this.svg.viewBox.baseVal.height / 236);
    for (const [at, value] of ticks(this.valueX(view[0]), this.valueX(view[0] + view[2]), false)) {
      make(axes, "path", {d: `M${across(toX(at))} ${top}V${top + high}`});
      make(axes, "text", {class: "x", x: across(toX(at)), y: top + high + 14}).textContent = number(value);
    }
    for (const [at, value] of this.rows ? [] : ticks(this.valueY(view[1] + view[3]), this.valueY(view[1]), this.log, most)) {
      make(axes, "path", {d: `M${left} ${down(toY(at))}H${left + wide}`});
      make(axes, "text", {class: "y", x: left - 5, y: down(toY(at)) + 4}).textContent = number(value);
    }
    for (const label of this.svg.querySelectorAll("text.mark")) {
      const {x, y} = label.dataset, isX = x !== undefined;
      if (!x && !y) continue;
      const at = isX ? across(toX(+x)) : down(toY(this.log ? Math.log10(+y) : +y));
      const [from, size] = isX ? [left, wide] : [top, high];
      label.style.display = at >= from - 1 && at <= from + size + 1 ? "" : "none";
      label.setAttribute(isX ? "x" : "y", isX ? at + (label.getAttribute("text-anchor") ? -3 : 3) : Math.max(at - 3, top + 11));
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
      const text = this.log ? (10 ** value).toPrecision(3) : value.toFixed(Math.max(0, Math.min(9, -Math.floor(Math.log10(step)))));
      return `${name} ${text}`;
    });
    const step = (this.x[1] - this.x[0]) / 2000;
    this.told.textContent = `${this.valueX(place).toFixed(Math.max(0, -Math.floor(Math.log10(step))))} ${this.svg.dataset.unit ?? "s"}: ${parts.join(", ")}`;
  }
}
const charts = all.map(svg => new Chart(svg));
window.gyrostatCharts = charts;
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
