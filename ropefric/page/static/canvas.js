// Pictures on a canvas, in the colours of the page: axes, curves with bands, points with bars, what was not tested.
import { plain } from "./frame.js";

export const EDGE = { left: 54, right: 8, top: 20, bottom: 34 };

export function penOf(canvas) {
  const ratio = devicePixelRatio || 1, pen = canvas.getContext("2d");
  canvas.width = Math.round(canvas.clientWidth * ratio);
  canvas.height = Math.round(canvas.clientHeight * ratio);
  pen.scale(ratio, ratio);
  pen.font = "12px system-ui, sans-serif";
  const style = getComputedStyle(document.documentElement), color = (name) => style.getPropertyValue(`--${name}`).trim();
  const line = (x0, y0, x1, y1) => { pen.beginPath(); pen.moveTo(x0, y0); pen.lineTo(x1, y1); pen.stroke(); };
  return { pen, color, line };
}

export function ticks(low, high, most) {
  const rough = (high - low) / Math.max(1, most), power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough), found = [];
  for (let n = Math.ceil(low / step); n * step <= high && found.length < 50; n++) found.push(+(n * step).toPrecision(12));
  return found;
}

// `series`: name, color, line [[x, y]], band [[x, low, high]], points [[x, y, low, high]]; `tested`: x from, to, or empty; `shade`:
// x from, to; `mark`: x. Returns the scales, or null where there is nothing to draw.
export function chart(canvas, { series, x, y, tested = null, shade = null, mark = null, zero = false }) {
  const { pen, color, line } = penOf(canvas), all = { x: [], y: zero ? [0] : [] };
  for (const { line: curve = [], band = [], points = [] } of series) {
    for (const [at, ...values] of [...curve, ...band, ...points]) {
      all.x.push(at);
      all.y.push(...values.filter(Number.isFinite));
    }
  }
  if (!all.x.length || !all.y.length) return null;
  const least = (values) => values.reduce((a, b) => Math.min(a, b)), most = (values) => values.reduce((a, b) => Math.max(a, b));
  const span = (values, part) => {
    const low = least(values), high = most(values), margin = part * (high - low) || 0.05 * Math.abs(high) || 0.5;
    return [low - margin, high + margin];
  };
  const [left, right] = span(all.x, 0.02), [low, high] = span(all.y, 0.06);
  const width = canvas.clientWidth - EDGE.left - EDGE.right, height = canvas.clientHeight - EDGE.top - EDGE.bottom;
  const X = (t) => EDGE.left + (t - left) / (right - left) * width, Y = (f) => EDGE.top + (high - f) / (high - low) * height;
  const bottom = EDGE.top + height;
  pen.strokeStyle = color("line"); pen.fillStyle = color("soft"); pen.lineWidth = 1;
  pen.textAlign = "right"; pen.textBaseline = "middle";
  for (const at of ticks(low, high, height / 45)) { line(EDGE.left, Y(at), EDGE.left + width, Y(at)); pen.fillText(plain(at, 6), EDGE.left - 6, Y(at)); }
  pen.textAlign = "center"; pen.textBaseline = "alphabetic";
  for (const at of ticks(left, right, width / 80)) { line(X(at), bottom, X(at), bottom + 4); pen.fillText(plain(at, 6), X(at), bottom + 16); }
  pen.fillText(x, EDGE.left + width / 2, bottom + 30);
  pen.textAlign = "left"; pen.fillText(y, 4, 13);
  pen.save();
  pen.beginPath(); pen.rect(EDGE.left, EDGE.top, width, height); pen.clip();
  if (shade) { pen.fillStyle = color("sliding"); pen.fillRect(X(shade[0]), EDGE.top, X(shade[1]) - X(shade[0]), height); }
  if (tested) {
    const outside = tested.length ? [[left, tested[0]], [tested[1], right]] : [[left, right]];
    for (const [from, to] of outside) hatch(pen, X(from), X(to), EDGE.top, height, color("line"));
  }
  for (const one of series) {
    const own = color(one.color);
    pen.strokeStyle = pen.fillStyle = own;
    if (one.band?.length) {
      pen.globalAlpha = 0.18; pen.beginPath();
      for (const [at, from] of one.band) pen.lineTo(X(at), Y(from));
      for (const [at, , to] of [...one.band].reverse()) pen.lineTo(X(at), Y(to));
      pen.fill(); pen.globalAlpha = 1;
    }
    if (one.line?.length) {
      pen.lineWidth = one.thin ? 1.1 : 2; pen.beginPath();
      for (const [at, value] of one.line) if (Number.isFinite(value)) pen.lineTo(X(at), Y(value));
      pen.stroke();
    }
    pen.lineWidth = 1.5;
    for (const [at, value, from, to] of one.points ?? []) {
      if (Number.isFinite(from)) line(X(at), Y(from), X(at), Y(to));
      pen.beginPath(); pen.arc(X(at), Y(value), 3.5, 0, 7);
      if (one.hollow) { pen.save(); pen.fillStyle = color("ground"); pen.fill(); pen.restore(); pen.stroke(); } else pen.fill();
    }
  }
  if (mark !== null) { pen.strokeStyle = color("pick"); pen.setLineDash([5, 4]); line(X(mark), EDGE.top, X(mark), bottom); pen.setLineDash([]); }
  pen.restore();
  pen.strokeStyle = color("line"); pen.lineWidth = 1; pen.strokeRect(EDGE.left, EDGE.top, width, height);
  return { at: (pixel) => left + (pixel - EDGE.left) / width * (right - left), begin: least(all.x), end: most(all.x) };
}

function hatch(pen, from, to, top, height, color) {
  if (to <= from) return;
  pen.save();
  pen.beginPath(); pen.rect(from, top, to - from, height); pen.clip();
  pen.strokeStyle = color; pen.lineWidth = 1.5; pen.beginPath();
  for (let at = from - height; at < to; at += 9) { pen.moveTo(at, top + height); pen.lineTo(at + height, top); }
  pen.stroke();
  pen.restore();
}
