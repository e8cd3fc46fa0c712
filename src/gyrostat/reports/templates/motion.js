"use strict";
// Motion of a run: the body, its boresight and its wheels, drawn in 3D.
for (const figure of document.querySelectorAll("figure.motion")) {
const run = JSON.parse(figure.querySelector("script").textContent);
const canvas = figure.querySelector("canvas"), pen = canvas.getContext("2d");
const moment = figure.querySelector(".moment"), told = figure.querySelector(".now");
const play = figure.querySelector(".play");
let azimuth = 0.7, elevation = 0.45, playing = false, began = 0, from = 0;
const cross = (a, b) => [a[1]*b[2] - a[2]*b[1], a[2]*b[0] - a[0]*b[2], a[0]*b[1] - a[1]*b[0]];
const sum = (a, b, s) => a.map((v, k) => v + s * b[k]);
const unit = a => { const n = Math.hypot(...a); return a.map(v => v / n); };
// body to inertial axes: v + 2 w (u x v) + 2 u x (u x v), quaternion (w, u)
const turn = (q, v) => { const u = q.slice(1), t = cross(u, v); return sum(sum(v, t, 2 * q[0]), cross(u, t), 2); };
const view = p => {
  const ca = Math.cos(azimuth), sa = Math.sin(azimuth), ce = Math.cos(elevation), se = Math.sin(elevation);
  const x = -sa * p[0] + ca * p[1], depth = ca * p[0] + sa * p[1];
  return [380 + 130 * x, 210 - 130 * (ce * p[2] - se * depth), ce * depth + se * p[2]];
};
const line = (points, colour, width, dash = []) => {
  pen.beginPath(); pen.setLineDash(dash); pen.strokeStyle = colour; pen.lineWidth = width;
  points.map(view).forEach((p, k) => k ? pen.lineTo(p[0], p[1]) : pen.moveTo(p[0], p[1]));
  pen.stroke(); pen.setLineDash([]);
};
const write = (text, place, colour) => { const p = view(place); pen.fillStyle = colour; pen.fillText(text, p[0] + 4, p[1]); };
const fastest = Math.max(1e-9, ...run.speed.map(row => Math.max(...row.map(Math.abs))));
function box(q) {
  const faces = [];
  for (let axis = 0; axis < 3; axis++) for (const side of [-1, 1]) {
    const corners = [[-1, -1], [-1, 1], [1, 1], [1, -1]].map(([a, b]) => {
      const p = [0, 0, 0]; p[axis] = side; p[(axis + 1) % 3] = a; p[(axis + 2) % 3] = b;
      return view(turn(q, p.map((v, k) => 0.6 * v * run.sides[k])));
    });
    faces.push([corners.reduce((d, c) => d + c[2], 0), corners]);
  }
  faces.sort((a, b) => a[0] - b[0]).forEach(([, corners], k) => {
    pen.beginPath(); corners.forEach((c, j) => j ? pen.lineTo(c[0], c[1]) : pen.moveTo(c[0], c[1])); pen.closePath();
    pen.fillStyle = k < 3 ? "#dfe5ec" : "rgba(196, 208, 222, .55)"; pen.fill();
    pen.strokeStyle = "#6b7077"; pen.lineWidth = 1; pen.stroke();
  });
}
function draw() {
  const k = +moment.value, q = run.attitude[k];
  pen.clearRect(0, 0, canvas.width, canvas.height); pen.font = "13px system-ui, sans-serif";
  [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]].forEach(([name, axis]) => {
    line([[0, 0, 0], axis.map(v => 1.45 * v)], "#c9cdd3", 1); write(name, axis.map(v => 1.48 * v), "#9aa0a8");
  });
  box(q);
  run.axes.forEach((axis, w) => {
    const speed = run.speed[k][w], share = speed / fastest;
    const colour = Math.abs(share) < 0.01 ? "#8a8f98" : share > 0 ? "#1f5fa8" : "#d9822b";
    const first = unit(cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0])), second = cross(axis, first);
    const at = angle => turn(q, sum(sum(axis.map(v => 0.95 * v), first, 0.22 * Math.cos(angle)), second, 0.22 * Math.sin(angle)));
    line([...Array(33).keys()].map(j => at(j * Math.PI / 16)), colour, 2.5);
    const swept = 6 * share * run.time[k];  // shown slowly: six radians in a second at the fastest
    line([at(swept), at(swept + Math.PI)], colour, 1.5);
    write(`${run.wheels[w]} ${(speed * 30 / Math.PI).toFixed(0)} rpm`, turn(q, axis.map(v => 1.3 * v)), colour);
  });
  line([[0, 0, 0], turn(run.target[k], run.boresight).map(v => 1.7 * v)], "#50555c", 1.5, [6, 5]);
  line([[0, 0, 0], turn(q, run.boresight).map(v => 1.7 * v)], "#c8461e", 2.5);
  told.textContent = `${run.time[k].toFixed(1)} s, error ${run.error[k].toPrecision(3)} deg`;
}
function step(now) {
  if (!playing) return;
  const last = run.time.length - 1, k = from + Math.floor((now - began) / 1000 * run.time.length / 20);
  moment.value = Math.min(k, last); draw();
  if (k < last) requestAnimationFrame(step); else { playing = false; play.textContent = "play"; }
}
play.onclick = () => {
  playing = !playing; play.textContent = playing ? "stop" : "play";
  if (+moment.value === run.time.length - 1) moment.value = 0;
  began = performance.now(); from = +moment.value; if (playing) requestAnimationFrame(step);
};
moment.oninput = () => { playing = false; play.textContent = "play"; draw(); };
canvas.onpointermove = event => {
  if (!event.buttons) return;
  azimuth -= 0.01 * event.movementX; elevation = Math.max(-1.5, Math.min(1.5, elevation + 0.01 * event.movementY)); draw();
};
const asked = /#frame=(\d+)/.exec(location.hash);
if (asked) moment.value = asked[1];
draw();
}
