"use strict";
// Motion of a run: the body with its boresight and wheels, and what is around it, drawn in 3D.
for (const figure of document.querySelectorAll("figure.motion")) {
const run = JSON.parse(figure.querySelector("script").textContent), world = run.world;
const canvas = figure.querySelector("canvas"), pen = canvas.getContext("2d");
const [moment, told, around, play, chosen] = ["moment", "now", "around", "play", "axes"].map(name => figure.querySelector(`.${name}`));
const night = matchMedia("(prefers-color-scheme: dark)");
const INKS = {
  light: { grid: "#c9cdd3", name: "#7c828b", far: "#dfe5ec", near: "rgba(196, 208, 222, .55)", edge: "#6b7077",
    goal: "#50555c", sight: "#c8461e", view: "rgba(200, 70, 30, .16)", sun: "#d99a00", velocity: "#2b8a4b", ground: "#a0248f",
    earth: "rgba(70, 130, 200, .22)", limb: "#3a78b8", land: "rgba(58, 120, 184, .55)", plus: "#1f5fa8", minus: "#d9822b" },
  dark: { grid: "#474d55", name: "#9aa2ac", far: "#3a424c", near: "rgba(96, 110, 128, .55)", edge: "#a3abb5",
    goal: "#b4bac2", sight: "#ff7f57", view: "rgba(255, 127, 87, .2)", sun: "#ffcf4d", velocity: "#63cf88", ground: "#ec7fdd",
    earth: "rgba(80, 150, 230, .25)", limb: "#7db6f0", land: "rgba(125, 182, 240, .5)", plus: "#76b0f5", minus: "#f0a35a" },
};
const AWAY = world ? 1.5 : 1.7, SIZE = world ? 0.7 : 1;  // length of directions, size of the body
let azimuth = 0.7, elevation = 0.45, playing = false, began = 0, from = 0;
let width = 760, height = 420, scale = 130, k = 0, ink = INKS.light, toAxes = p => p;
const cross = (a, b) => [a[1]*b[2] - a[2]*b[1], a[2]*b[0] - a[0]*b[2], a[0]*b[1] - a[1]*b[0]];
const dot = (a, b) => a[0]*b[0] + a[1]*b[1] + a[2]*b[2];
const sum = (a, b, s) => a.map((v, j) => v + s * b[j]);
const unit = a => { const n = Math.hypot(...a); return a.map(v => v / n); };
const times = (a, s) => a.map(v => v * s);
const beside = a => unit(cross(a, Math.abs(a[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
const ring = (count, place) => [...Array(count + 1).keys()].map(j => place(2 * Math.PI * j / count));
// cone about a unit vector: its rim on the sphere of unit radius
const rim = (axis, half, count = 48) => { const a = beside(axis), b = cross(axis, a);
  return ring(count, t => sum(sum(times(axis, Math.cos(half)), a, Math.sin(half) * Math.cos(t)), b, Math.sin(half) * Math.sin(t))); };
const degrees = (a, b) => (180 / Math.PI * Math.atan2(Math.hypot(...cross(a, b)), dot(a, b))).toFixed(2);
// body to inertial axes: v + 2 w (u x v) + 2 u x (u x v), quaternion (w, u)
const turn = (q, v) => { const u = q.slice(1), t = cross(u, v); return sum(sum(v, t, 2 * q[0]), cross(u, t), 2); };
const back = (q, v) => turn([q[0], -q[1], -q[2], -q[3]], v);
function axesOf(name) {
  if (name === "body") return p => back(run.attitude[k], p);
  if (name !== "orbit") return p => p;
  const up = unit(world.position[k]), side = unit(cross(up, world.velocity[k])), ahead = cross(side, up);
  return p => [dot(p, ahead), dot(p, side), dot(p, up)];
}
const view = place => {
  const p = toAxes(place);
  const ca = Math.cos(azimuth), sa = Math.sin(azimuth), ce = Math.cos(elevation), se = Math.sin(elevation);
  const x = -sa * p[0] + ca * p[1], depth = ca * p[0] + sa * p[1];
  return [width / 2 + scale * x, height / 2 - scale * (ce * p[2] - se * depth), ce * depth + se * p[2]];
};
const trace = points => { pen.beginPath(); points.forEach((p, j) => j ? pen.lineTo(p[0], p[1]) : pen.moveTo(p[0], p[1])); };
const line = (points, colour, thick, dash = []) => {
  pen.setLineDash(dash); pen.strokeStyle = colour; pen.lineWidth = thick;
  trace(points.map(view)); pen.stroke(); pen.setLineDash([]);
};
const write = (text, place, colour) => { const p = view(place); pen.fillStyle = colour; pen.fillText(text, p[0] + 4, p[1] - 2); };
const spot = (place, size, colour) => { const p = view(place); pen.beginPath(); pen.arc(p[0], p[1], size, 0, 7); pen.fillStyle = colour; pen.fill(); };
const largest = () => run.speed.reduce((most, row) => row.reduce((m, v) => Math.max(m, Math.abs(v)), most), 1e-9);
let fastest = largest();
function hull(points) {  // convex hull, monotone chain
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = list => list.reduce((kept, p) => {
    while (kept.length > 1) {
      const [a, b] = kept.slice(-2);
      if ((b[0] - a[0]) * (p[1] - a[1]) > (b[1] - a[1]) * (p[0] - a[0])) break;
      kept.pop();
    }
    return [...kept, p];
  }, []).slice(0, -1);
  return [...half(sorted), ...half(sorted.reverse())];
}
function earth() {
  const p = world.position[k], distance = Math.hypot(...p), nadir = times(p, -1 / distance), edge = Math.asin(1 / distance);
  const limb = rim(nadir, edge).map(d => times(d, AWAY));
  const cap = [...Array(6).keys()].flatMap(j => rim(nadir, edge * (j + 1) / 6).map(d => times(d, AWAY)));
  trace(hull(cap.map(view))); pen.closePath(); pen.fillStyle = ink.earth; pen.fill();
  const below = back(world.earth[k], unit(p)), rad = Math.PI / 180;
  const latitude = Math.asin(below[2]) / rad, longitude = Math.atan2(below[1], below[0]) / rad;
  const seen = (a, b) => {  // a place on the Earth as a direction; null beyond the horizon
    const g = turn(world.earth[k], [Math.cos(a * rad) * Math.cos(b * rad), Math.cos(a * rad) * Math.sin(b * rad), Math.sin(a * rad)]);
    return dot(p, g) > 1 ? times(unit(sum(g, p, -1)), AWAY) : null;
  };
  const drawn = points => points.forEach((d, j) => { if (j && d && points[j - 1]) line([points[j - 1], d], ink.land, 0.8); });
  const wide = Math.min(180, 25 / Math.max(0.02, Math.cos(latitude * rad))), steps = [...Array(41).keys()].map(j => j / 20 - 1);
  for (let a = 5 * Math.ceil((latitude - 25) / 5); a <= latitude + 25; a += 5)
    if (Math.abs(a) < 90) drawn(steps.map(s => seen(a, longitude + wide * s)));
  for (let b = 5 * Math.ceil((longitude - wide) / 5); b < longitude + wide; b += 5)
    drawn(steps.map(s => seen(Math.max(-85, Math.min(85, latitude + 25 * s)), b)));
  line(limb, ink.limb, 1.5);
  write("Earth", times(nadir, 1.06 * AWAY), ink.limb);
}
function directions(sight) {
  const p = world.position[k], nadir = times(unit(p), -1), sun = world.sun[k], ahead = world.velocity[k], ground = world.ground[k];
  line([[0, 0, 0], times(nadir, AWAY)], ink.limb, 1.5);
  line([[0, 0, 0], times(sun, AWAY)], ink.sun, 1.5); spot(times(sun, AWAY), 8, ink.sun);
  write(world.light[k] > 0 ? "  Sun" : "  Sun (eclipse)", times(sun, AWAY), ink.sun);
  line([[0, 0, 0], times(ahead, AWAY)], ink.velocity, 2);
  const wing = s => sum(times(ahead, 0.92 * AWAY), cross(unit(p), ahead), s * 0.05);
  line([wing(1), times(ahead, AWAY), wing(-1)], ink.velocity, 2); write("velocity", times(ahead, 1.06 * AWAY), ink.velocity);
  let text = `mode ${world.mode[k]}; boresight to Earth ${degrees(sight, nadir)}, Sun ${degrees(sight, sun)}, velocity ${degrees(sight, ahead)}`;
  if (ground) {
    const way = unit(sum(ground, p, -1)), above = dot(sum(ground, p, -1), ground) < 0;
    line([[0, 0, 0], times(way, AWAY)], ink.ground, 2, above ? [] : [3, 4]); spot(times(way, AWAY), 4, ink.ground);
    write(above ? "target" : "target (below horizon)", times(way, AWAY), ink.ground);
    text += `, target ${degrees(sight, way)}`;
  }
  around.textContent = text + ` deg; ${world.light[k] > 0 ? world.light[k] < 1 ? "penumbra" : "sunlit" : "eclipse"}`;
}
function box(q) {
  const faces = [];
  for (let axis = 0; axis < 3; axis++) for (const side of [-1, 1]) {
    const corners = [[-1, -1], [-1, 1], [1, 1], [1, -1]].map(([a, b]) => {
      const p = [0, 0, 0]; p[axis] = side; p[(axis + 1) % 3] = a; p[(axis + 2) % 3] = b;
      return view(turn(q, p.map((v, j) => 0.6 * SIZE * v * run.sides[j])));
    });
    faces.push([corners.reduce((d, c) => d + c[2], 0), corners]);
  }
  faces.sort((a, b) => a[0] - b[0]).forEach(([, corners], j) => {
    trace(corners); pen.closePath();
    pen.fillStyle = j < 3 ? ink.far : ink.near; pen.fill();
    pen.strokeStyle = ink.edge; pen.lineWidth = 1; pen.stroke();
  });
}
function fit() {
  const ratio = devicePixelRatio || 1;
  width = Math.min(760, canvas.clientWidth || 760); height = Math.max(300, width * 420 / 760); scale = Math.min(width / 3.6, height * 13 / 42);
  canvas.style.height = `${height}px`; canvas.width = width * ratio; canvas.height = height * ratio;
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
}
function draw() {
  k = +moment.value; ink = INKS[night.matches ? "dark" : "light"]; toAxes = axesOf(chosen.value);
  const q = run.attitude[k], sight = unit(turn(q, run.boresight));
  pen.clearRect(0, 0, width, height); pen.font = "13px system-ui, sans-serif";
  const axes = [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]], body = world || chosen.value === "body";
  const behind = !world || view(times(world.position[k], -1))[2] < 0;
  if (world && behind) earth();
  axes.forEach(([name, axis]) => {
    const way = body ? turn(q, axis) : axis, long = body ? SIZE : 1.45;
    line([[0, 0, 0], times(way, long)], body ? ink.edge : ink.grid, 1); write(name, times(way, long + 0.03), ink.name);
  });
  box(q);
  run.axes.forEach((axis, w) => {
    const speed = run.speed[k][w], share = speed / fastest;
    const colour = Math.abs(share) < 0.01 ? ink.name : share > 0 ? ink.plus : ink.minus;
    const first = beside(axis), second = cross(axis, first);
    const at = angle => turn(q, times(sum(sum(times(axis, 0.95), first, 0.22 * Math.cos(angle)), second, 0.22 * Math.sin(angle)), SIZE));
    line(ring(32, at), colour, 2.5);
    const swept = 6 * share * run.time[k];  // shown slowly: six radians in a second at the fastest
    line([at(swept), at(swept + Math.PI)], colour, 1.5);
    write(`${run.wheels[w]} ${(speed * 30 / Math.PI).toFixed(0)} rpm`, turn(q, times(axis, 1.3 * SIZE)), colour);
  });
  if (run.field_of_view) {
    const rays = rim(sight, run.field_of_view / 2).map(d => times(d, AWAY));
    trace(hull([[0, 0, 0], ...rays].map(view))); pen.closePath(); pen.fillStyle = ink.view; pen.fill(); line(rays, ink.sight, 1);
  }
  line([[0, 0, 0], times(turn(run.target[k], run.boresight), AWAY)], ink.goal, 1.5, [6, 5]);
  if (run.nominal?.[k]) line([[0, 0, 0], times(turn(run.nominal[k], run.boresight), AWAY)], ink.name, 1.5);
  line([[0, 0, 0], times(turn(q, run.boresight), AWAY)], ink.sight, 2.5);
  if (world) directions(sight);
  if (world && !behind) earth();
  told.textContent = `${run.time[k].toFixed(1)} s, error ${run.error[k].toPrecision(3)} deg`;
}
function step(now) {
  if (!playing) return;
  const last = run.time.length - 1, next = from + Math.floor((now - began) / 1000 * run.time.length / 20);
  moment.value = Math.min(next, last); draw();
  if (next < last) requestAnimationFrame(step); else { playing = false; play.textContent = "play"; }
}
play.onclick = () => {
  playing = !playing; play.textContent = playing ? "stop" : "play";
  if (+moment.value === run.time.length - 1) moment.value = 0;
  began = performance.now(); from = +moment.value; if (playing) requestAnimationFrame(step);
};
moment.oninput = () => { playing = false; play.textContent = "play"; draw(); };
chosen.onchange = draw; night.addEventListener("change", draw);
canvas.onpointermove = event => {
  if (!event.buttons) return;
  azimuth -= 0.01 * event.movementX; elevation = Math.max(-1.5, Math.min(1.5, elevation + 0.01 * event.movementY)); draw();
};
const asked = /#frame=(\d+)(?:&axes=(\w+))?/.exec(location.hash);
if (asked) { moment.value = asked[1]; if (asked[2]) chosen.value = asked[2]; }
// another run, of the same scenario; `nominal`: attitudes of the nominal one
figure.replaceRun = next => {
  Object.assign(run, next); fastest = largest();
  moment.max = run.time.length - 1;
  draw();
};
// a run inside a campaign's page has no size before it is opened
new ResizeObserver(() => { fit(); draw(); }).observe(canvas);
fit(); draw();
}
