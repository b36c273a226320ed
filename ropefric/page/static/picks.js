// Step 2: recordings one by one, the pick of each, and what a person decides about it.
import { $, call, calm, enable, fail as failed, isEnabled, known, make, plain, readAgain, redraw, shown, step as declare, tableRow, unit, withEnds, withStd } from "./frame.js";
import { EDGE, penOf, ticks } from "./canvas.js";

const ROW = 46, BEYOND = 8;
const SIGNS = { ask: "?", "without a force": "–", rejected: "r", excluded: "✕", kept: "✓" };
export const S = { rows: new Map(), order: [], shown: [], trial: "", info: null, curve: null, view: null, draft: null, preview: null,
  slack: false, undo: 0, answer: {} };

let queue = Promise.resolve();  // one decision after the other, none left out
function write(path, body, words) {
  queue = queue.then(async () => {
    try {
      const found = await call(path, {}, body);
      calm();
      say(words);
      if (found.order) take(found);
      else if (found.number !== S.answer.number + 1) take(await call("overview"));  // another window has decided too
      for (const [name, row] of Object.entries(found.rows)) S.rows.set(name, row);
      S.undo = found.undo;
      count(found.counts);
      showAnswer(found);
      drawList();
      if (S.trial === body.trial || !body.trial) await choose(S.trial, true);
    } catch (error) { fail(error); }
  });
  return queue;
}

const say = (words) => { $("said").textContent = words; };
function fail(error) {
  failed(error);
  say("");
}

const symbol = () => S.slack ? "F_B" : "F_A";
// --- the list ---

const kindOf = (row) => row.status === "doubtful" && row.outcome === "without a force" ? "ask" : row.outcome;
const WORDS = { ask: "to decide", kept: "counts", rejected: "rejected by the rule", excluded: "excluded" };
const wordsOf = (row) => kindOf(row) === "without a force" ? row.status : WORDS[kindOf(row)];
const TESTS = {
  all: ["all", () => true], ask: ["doubtful, to decide", (r) => kindOf(r) === "ask"],
  none: ["without a force", (r) => r.outcome === "without a force"],
  decided: ["decided by a person", (r) => r.decision || (r.excluded && r.by)],
  kept: ["counting", (r) => r.outcome === "kept"], rejected: ["rejected by the rule", (r) => r.outcome === "rejected"],
  excluded: ["excluded", (r) => r.outcome === "excluded"],
};

// Doubtful ones first, then as the list has them, or the least sure first: what a person excluded, and what has no
// probability, at the end.
function arrange() {
  const kinds = ["ask", "without a force", "rejected", "kept", "excluded"], bySure = $("by-order").value === "sure";
  const rank = (row) => bySure ? kindOf(row) === "ask" ? 0 : kindOf(row) === "excluded" ? 2 : 1 : kinds.indexOf(kindOf(row));
  const sure = (row) => bySure ? row.probability ?? 2 : 0;
  S.order = [...S.rows].map(([name, row], place) => [rank(row), sure(row), place, name])
    .sort((a, b) => a[0] - b[0] || a[1] - b[1] || a[2] - b[2]).map((e) => e[3]);
}

export function take(tree) {
  S.slack = tree.slack;
  S.rows = new Map(tree.order.map((name) => [name, tree.rows[name]]));
  arrange();
  $("where-to").textContent = `decisions of ${tree.by} go into ${tree.list}`;
  S.undo = tree.undo;
  count(tree.counts);
  const chosen = $("by-condition").value;
  const conditions = [...new Set(tree.order.map((name) => tree.rows[name].condition))];
  $("by-condition").replaceChildren(new Option("all", ""), ...conditions.map((one) => new Option(one, one)));
  $("by-condition").value = conditions.includes(chosen) ? chosen : "";
  filter();
}

function count(counts) {
  const rows = [...S.rows.values()], asked = rows.filter((row) => kindOf(row) === "ask").length;
  $("counts").textContent = `${counts.n_trials} trials: ${asked} to decide, ${counts.n_kept} counting, ${counts.n_rejected} rejected, `
    + `${counts.n_excluded} excluded, ${counts.n_without_force} without a force`;
  const chosen = $("by-status").value || "all", tests = { ...TESTS };
  for (const status of Object.keys(counts.status)) tests[`=${status}`] = [`status ${status}`, (row) => row.status === status];
  S.tests = tests;
  $("by-status").replaceChildren(...Object.entries(tests).map(([key, [words, test]]) =>
    new Option(`${words} (${rows.filter(test).length})`, key)));
  $("by-status").value = tests[chosen] ? chosen : "all";
}

function filter() {
  const [, test] = S.tests[$("by-status").value], condition = $("by-condition").value;
  const text = $("by-text").value.trim().toLowerCase();
  S.shown = S.order.filter((name) => {
    const row = S.rows.get(name);
    return test(row) && (!condition || row.condition === condition)
      && (!text || name.toLowerCase().includes(text) || row.file.toLowerCase().includes(text));
  });
  $("n-shown").textContent = `${S.shown.length} of ${S.order.length} shown`;
  $("space").style.height = `${S.shown.length * ROW}px`;
  $("list").scrollTop = 0;
  drawList();
}

// The rows that are seen, and some beyond them, so that a list that is scrolled a little stays as it is drawn.
let drawn = [0, 0];
function drawSeen() {
  const list = $("list"), first = Math.floor(list.scrollTop / ROW), last = Math.ceil((list.scrollTop + list.clientHeight) / ROW);
  if (first < drawn[0] || Math.min(last, S.shown.length) > drawn[1]) drawList();
}
function drawList() {
  const list = $("list"), first = Math.max(0, Math.floor(list.scrollTop / ROW) - BEYOND);
  const last = Math.min(S.shown.length, Math.ceil((list.scrollTop + list.clientHeight) / ROW) + BEYOND);
  const rows = [];
  drawn = [first, last];
  for (let place = first; place < last; place++) {
    const name = S.shown[place], row = S.rows.get(name), kind = kindOf(row);
    const made = make("div", "", `row${kind === "ask" ? " ask" : kind === "excluded" || kind === "rejected" ? " out" : ""}`);
    made.id = `row-${place}`;
    made.setAttribute("role", "option");
    made.setAttribute("aria-selected", String(name === S.trial));
    made.setAttribute("aria-setsize", S.shown.length);
    made.setAttribute("aria-posinset", place + 1);
    made.style.transform = `translateY(${place * ROW}px)`;
    made.dataset.trial = name;
    const force = known(row.force_N) ? `${plain(row.force_N)} N` : wordsOf(row);
    made.title = `${wordsOf(row)}${known(row.probability) ? `, probability ${row.probability.toFixed(2)}` : ""}${row.excluded ? `: ${row.excluded}` : ""}${row.decision ? `; ${row.decision} by ${row.by}` : ""}`;
    made.append(make("span", SIGNS[kind], "sign"), make("span", name + (row.decision ? " ✎" : ""), "name"),
      make("span", force, "force"), make("span", row.condition, "where"),
      make("span", known(row.probability) ? `P ${row.probability.toFixed(2)}` : "", "sure"));
    rows.push(made);
  }
  $("space").replaceChildren(...rows);
  const place = S.shown.indexOf(S.trial);
  if (place >= first && place < last) list.setAttribute("aria-activedescendant", `row-${place}`);
  else list.removeAttribute("aria-activedescendant");
}

function step(by) {
  if (!S.shown.length) return;
  const place = S.shown.indexOf(S.trial);
  const next = place < 0 ? 0 : Math.min(S.shown.length - 1, Math.max(0, place + by));
  if (place === next) return say(by > 0 ? "This is the last one of the list." : "This is the first one of the list.");
  choose(S.shown[next]);
}

// --- one trial ---

async function choose(name, again = false) {
  const is = S.rows.get(name);
  if (!is) return;
  S.trial = name;
  if (!again) { S.view = null; S.curve = null; say(""); }
  S.draft = S.preview = null;
  const list = $("list"), top = S.shown.indexOf(name) * ROW;
  if (top >= 0 && (top < list.scrollTop || top + ROW > list.scrollTop + list.clientHeight))
    list.scrollTop = Math.max(0, top - list.clientHeight / 2);
  drawList();
  try {
    const info = await call("trial", { trial: name });
    if (S.trial !== name) return;
    S.info = info;
    showInfo();
    await loadCurve();
  } catch (error) { fail(error); }
}

function showInfo() {
  const row = S.rows.get(S.trial), info = S.info, ask = kindOf(row) === "ask";
  $("trial").textContent = S.trial;
  $("status").textContent = ask ? "doubtful: to decide" : wordsOf(row);
  $("status").className = `badge${ask ? " ask" : ""}`;
  $("where").textContent = `${row.condition} · ${row.file}`;
  const decided = row.decision ? `${row.decision} by ${row.by || "?"}: ${row.why}. ` : row.why ? `${row.by}: ${row.why}. ` : "";
  $("detail").textContent = (row.excluded ? `Excluded${row.by ? ` by ${row.by}` : ""}: ${row.excluded}. ` : "") + decided
    + [info.detail, ask ? `Choose a candidate, click where the break-away is, or exclude it` : info.advice.replace(/\.$/, "")]
      .filter(Boolean).map((said) => `${said[0].toUpperCase()}${said.slice(1)}.`).join(" ");
  const facts = [[symbol(), withStd(info.picked[0], info.picked[1])], ["at", unit(info.picked[2], "s", 6)],
    ["apparent μ", plain(info.mu)],
    ...info.numbers.map(([what, value, std, name, digits]) => [what, std ? withStd(value, std) : unit(value, name, digits).trim()])];
  const notes = [...info.notes, ...info.problems];
  $("facts").replaceChildren(...facts.flatMap(([what, value]) => [make("dt", what), make("dd", value)]),
    ...notes.flatMap((note, place) => [make("dt", place ? "" : "notes"), make("dd", note)]));
  showPlaces();
  fillEvents($("candidates"), info.candidates, true);
  fillEvents($("events"), info.events, false);
  enable($("do-clear"), row.decision || row.why || (row.excluded && row.by));
  enable($("do-undo"), S.undo);
}

const REASONS = { "no-breakaway": "no break-away", "no-peak": "no peak", saturated: "a peak that is not to be seen", doubtful: "a damaged file" };
const MOST_PLACES = 6;
// What the strip under the trace shows, in words.
function showPlaces() {
  const { places = [], reasons = [] } = S.curve ?? {}, more = places.length - MOST_PLACES;
  const when = ([first, last]) => plain(first, 5) === plain(last, 5) ? plain(first, 5) : `${plain(first, 5)} to ${plain(last, 5)}`;
  const said = places.slice(0, MOST_PLACES).map((one) => `${when(one)} s (${one[2].toFixed(2)})`);
  if (more > 0) said.push(`${more} less likely one${more > 1 ? "s" : ""}`);
  const none = reasons.filter(([, p]) => p >= 0.01).map(([reason, p]) => `${REASONS[reason] ?? reason} (${p.toFixed(2)})`);
  $("places").hidden = !(said.length || none.length);
  $("places").textContent = $("places").hidden ? "" : `Where the break-away may be: ${[said.join(", ") || "nowhere", ...none].join("; ")}.`;
}

function fillEvents(panel, events, asks) {
  panel.hidden = !events.length;
  const [head, body] = [panel.querySelector("thead"), panel.querySelector("tbody")];
  const some = (name) => events.some((event) => known(event[name]) && event[name] !== "");
  const columns = [["at", (e) => unit(e.time_s, "s", 6)], ["force", (e) => unit(e.force_N, "N")],
    ["probability", (e) => known(e.probability) ? e.probability.toFixed(2) : "–"], ["fall", (e) => unit(e.drop_N, "N", 3)],
    ["evidence", (e) => e.evidence]].filter(([name]) => some({ at: "time_s", force: "force_N", fall: "drop_N" }[name] ?? name));
  head.replaceChildren(tableRow([asks ? "" : "kind", ...columns.map(([name]) => name)], "th"));
  redraw(body, ...events.slice(0, 200).map((event, place) => {
    let first = event.kind;
    if (asks) {
      first = make("td");
      const button = make("button", String(place + 1));
      button.setAttribute("aria-label", `Choose candidate ${place + 1}`);
      button.onclick = () => moveTo(event.time_s);
      first.append(button);
    }
    return tableRow([first, ...columns.map(([name, said]) => make("td", said(event), name === "evidence" ? "" : "force"))]);
  }));
}

// --- before and after ---

let waiting = 0;
function showAnswer(found) {
  S.answer = found;
  const { change, before, now, first } = found, rows = [];
  const law = (one) => !one ? "…" : one.error ? "none" : `${one.law} (${one.verdict})`;
  const lift = (one) => !one ? "…" : one.error ? one.error.message : one.lift
    ? withEnds(one.lift.lift_force_N, one.lift.interval_N)
    : one.parameters.map(([name, value, std]) => `${name} = ${plain(value)} ± ${plain(std, 2)}`).join(", ");
  const some = now || before || first, last = some && !some.error && !some.lift ? "Parameters" : "Lift force";
  const level = some && some.lift ? `, ${plain(100 * some.lift.level, 3)} % interval` : "";
  if (change) {
    const was = change.was.repeats, is = change.is.repeats;
    rows.push([`${symbol()} of ${change.trial}`, withStd(change.was.force_N, change.was.std_N), withStd(change.is.force_N, change.is.std_N)],
      ["It is", wordsOf(change.was), wordsOf(change.is)],
      ["Law", law(before), law(now)], [last + level, lift(before), lift(now)],
      ["Its condition: mean", unit(was.mean_N, "N", 6), unit(is.mean_N, "N", 6)],
      ["s", unit(was.std_N, "N"), unit(is.std_N, "N")],
      ["counting", `${was.n_kept} of ${was.n}`, `${is.n_kept} of ${is.n}`],
      ["rejected", was.rejected.join(", ") || "none", is.rejected.join(", ") || "none"]);
  } else rows.push(["Law", law(now)], [last + level, lift(now)]);
  const table = $("change");
  table.tHead.replaceChildren(tableRow(change ? ["", "before", "now"] : ["", "now"], "th"));
  table.tBodies[0].replaceChildren(...rows.map((cells) => {
    const made = tableRow(cells);
    if (change && cells[1] !== cells[2]) made.className = "moved";
    return made;
  }));
  $("computing").textContent = found.computing ? `computing (${found.computing})` : now && now.reason ? now.reason : "";
  $("since").textContent = change && first && now && first !== now && !now.error && !first.error
    ? `When the review began: ${law(first)}, ${lift(first)}.` : "";
  if (found.computing && !waiting) waiting = setTimeout(async () => {
    waiting = 0;
    try { showAnswer(await call("answer", {})); } catch (error) { fail(error); }
  }, 400);
}

// --- the picture ---

let fetching = false, wanted = false;
async function loadCurve() {
  if (fetching) { wanted = true; return; }
  fetching = true;
  const name = S.trial, view = S.view;
  try {
    const columns = Math.max(50, Math.round($("plot").clientWidth - 62));
    const curve = await call("curve", { trial: name, start_s: view ? view[0] : NaN, stop_s: view ? view[1] : NaN, columns });
    if (name === S.trial) { S.curve = curve; S.view = S.view || [curve.start_s, curve.stop_s]; }
  } catch (error) {
    if (name === S.trial) { S.curve = null; S.view = null; fail(error); }
  }
  fetching = false;
  showPlaces();
  draw();
  if (wanted) { wanted = false; loadCurve(); }
}

const STRIP = { title: 20, height: 30, narrowest: 2 };
export function scales() {
  const [start, stop] = S.view, curve = S.curve, strip = curve.places.length || curve.reasons.length ? STRIP.title + STRIP.height : 0;
  const plot = $("plot"), width = plot.clientWidth - EDGE.left - EDGE.right;
  const height = plot.clientHeight - EDGE.top - EDGE.bottom - strip;
  let low = Infinity, high = -Infinity;
  curve.time_s.forEach((t, i) => {
    if (t >= start && t <= stop) { low = Math.min(low, curve.low_N[i]); high = Math.max(high, curve.high_N[i]); }
  });
  if (low > high) [low, high] = [0, 1];
  const margin = 0.08 * (high - low) || 0.5;
  low -= margin; high += margin;
  return { x: (t) => EDGE.left + (t - start) / (stop - start) * width, y: (f) => EDGE.top + (high - f) / (high - low) * height,
    time: (x) => start + (x - EDGE.left) / width * (stop - start), width, height, low, high, strip };
}
function draw() {
  const plot = $("plot"), { pen, color, line } = penOf(plot);
  if (!S.curve || !S.info || !S.view) {
    pen.fillStyle = color("soft");
    return pen.fillText("no recording to draw", EDGE.left, 60);
  }
  const { x, y, width, height, low, high, strip } = scales(), right = EDGE.left + width, bottom = EDGE.top + height, info = S.info;
  const axis = bottom + strip;
  const label = (text, at, top, kind) => {
    const half = pen.measureText(text).width / 2 + 3, left = Math.min(Math.max(at, EDGE.left + half), right - half);
    pen.globalAlpha = 0.85; pen.fillStyle = color("ground"); pen.fillRect(left - half, top - 11, 2 * half, 15); pen.globalAlpha = 1;
    pen.fillStyle = color(kind); pen.textAlign = "center"; pen.fillText(text, left, top);
  };
  pen.save();
  pen.beginPath(); pen.rect(EDGE.left, 0, width, bottom); pen.clip();
  for (const phase of info.phases) {
    const from = Math.max(EDGE.left, x(phase.start_s)), to = Math.min(right, x(phase.end_s));
    if (to <= from) continue;
    pen.fillStyle = color(phase.name) || color("pale");
    pen.fillRect(from, EDGE.top, to - from, height);
    pen.fillStyle = color("soft"); pen.textAlign = "center";
    if (pen.measureText(phase.name).width < to - from) pen.fillText(phase.name, (from + to) / 2, EDGE.top - 6);
  }
  pen.restore();
  pen.strokeStyle = color("line"); pen.fillStyle = color("soft"); pen.lineWidth = 1;
  pen.textAlign = "right"; pen.textBaseline = "middle";
  for (const force of ticks(low, high, height / 55)) { line(EDGE.left, y(force), right, y(force)); pen.fillText(force, EDGE.left - 6, y(force)); }
  pen.textAlign = "center"; pen.textBaseline = "alphabetic";
  for (const time of ticks(...S.view, width / 90)) { line(x(time), axis, x(time), axis + 4); pen.fillText(time, x(time), axis + 16); }
  pen.fillText("time [s]", EDGE.left + width / 2, axis + 30);
  pen.textAlign = "left"; pen.fillText("F [N]", 4, 13);
  pen.save();
  pen.beginPath(); pen.rect(EDGE.left, EDGE.top, width, height); pen.clip();
  const curve = S.curve;
  pen.strokeStyle = color("trace"); pen.lineWidth = 1.2; pen.beginPath();
  curve.time_s.forEach((t, i) => {
    pen.lineTo(x(t), y(curve.high_N[i]));
    if (curve.low_N[i] !== curve.high_N[i]) pen.lineTo(x(t), y(curve.low_N[i]));
  });
  pen.stroke();
  if (curve.smoothed_N) {
    pen.strokeStyle = color("smooth"); pen.lineWidth = 1.6; pen.beginPath();
    curve.smoothed_N.forEach((f, i) => { if (known(f)) pen.lineTo(x(curve.time_s[i]), y(f)); });
    pen.stroke();
  }
  pen.fillStyle = color("event");
  for (const event of info.events) {
    const at = x(event.time_s), top = y(event.force_N) - 5;
    pen.beginPath(); pen.moveTo(at, top); pen.lineTo(at - 5, top - 8); pen.lineTo(at + 5, top - 8); pen.fill();
  }
  info.candidates.forEach((event, place) => {
    const at = x(event.time_s), top = Math.max(EDGE.top + 12, y(event.force_N) - 14);
    pen.strokeStyle = pen.fillStyle = color("candidate"); pen.lineWidth = 1.5;
    line(at, top + 8, at, bottom);
    pen.beginPath(); pen.arc(at, top, 9, 0, 7); pen.fillStyle = color("ground"); pen.fill(); pen.stroke();
    pen.fillStyle = color("candidate"); pen.textAlign = "center"; pen.fillText(place + 1, at, top + 4);
  });
  const mark = ([force, std, time], kind) => {
    if (!known(force) || !known(time)) return;
    const at = x(time), up = y(force);
    pen.strokeStyle = pen.fillStyle = color(kind); pen.lineWidth = 2;
    if (known(std)) for (const end of [force - std, force + std]) { line(at, up, at, y(end)); line(at - 6, y(end), at + 6, y(end)); }
    pen.beginPath(); pen.moveTo(at, up - 5); pen.lineTo(at + 5, up); pen.lineTo(at, up + 5); pen.lineTo(at - 5, up); pen.fill();
    label(`${symbol()} = ${withStd(force, std)}`, at, Math.max(EDGE.top + 14, y(force + (std || 0)) - 9), kind);
  };
  mark(info.picked, "pick");
  if (S.draft !== null) {
    pen.strokeStyle = color("draft"); pen.lineWidth = 1.5; pen.setLineDash([5, 4]);
    line(x(S.draft), EDGE.top, x(S.draft), bottom);
    pen.setLineDash([]);
    if (S.preview) mark(S.preview, "draft");
  }
  pen.restore();
  pen.strokeStyle = color("line"); pen.lineWidth = 1; pen.strokeRect(EDGE.left, EDGE.top, width, height);
  if (strip) {
    const top = axis - STRIP.height;
    pen.strokeRect(EDGE.left, top, width, STRIP.height);
    pen.fillStyle = color("soft"); pen.textAlign = "left"; pen.fillText("where the break-away may be", EDGE.left, top - 5);
    pen.textAlign = "right"; pen.fillText(1, EDGE.left - 6, top + 9); pen.fillText(0, EDGE.left - 6, axis);
    pen.save();
    pen.beginPath(); pen.rect(EDGE.left, top, width, STRIP.height); pen.clip();
    pen.fillStyle = color("candidate");
    for (const [first, last, p] of S.curve.places) {
      const wide = Math.max(x(last) - x(first), STRIP.narrowest), high = Math.max(p * STRIP.height, 1);
      pen.fillRect((x(first) + x(last) - wide) / 2, axis - high, wide, high);
    }
    pen.restore();
  }
  plot.setAttribute("aria-label", `Recording ${S.trial}, ${plain(S.view[0], 5)} s to ${plain(S.view[1], 5)} s: `
    + (known(info.picked[0]) ? `${symbol()} = ${withStd(info.picked[0], info.picked[1])} at ${plain(info.picked[2], 6)} s` : info.detail));
}

// --- zoom, and moving the pick ---

export function show(start, stop) {
  const { begin_s, end_s } = S.curve, least = (end_s - begin_s) * 1e-5;
  let span = Math.min(Math.max(stop - start, least), end_s - begin_s);
  start = Math.min(Math.max(start, begin_s), end_s - span);
  S.view = [start, start + span];
  draw();
  loadCurve();
}
const whole = () => S.curve && show(S.curve.begin_s, S.curve.end_s);
function zoom(factor, at) {
  if (!S.curve) return;
  const [start, stop] = S.view, middle = at ?? (start + stop) / 2;
  show(middle - (middle - start) * factor, middle + (stop - middle) * factor);
}
function place() {
  if (S.draft !== null) return S.draft;
  if (known(S.info.picked[2])) return S.info.picked[2];
  if (S.info.candidates.length) return S.info.candidates[0].time_s;
  const highest = S.curve.high_N.indexOf(Math.max(...S.curve.high_N));
  return S.curve.time_s[highest];
}
function zoomAtPeak() {
  if (!S.curve) return;
  const at = place(), all = S.curve.end_s - S.curve.begin_s, span = Math.min(all, Math.max(0.06 * all, 12 * (S.info.window_s || 0)));
  show(at - span / 2, at + span / 2);
}

let settling = 0;
function moveTo(time) {
  if (!S.curve) return;
  S.draft = Math.min(Math.max(time, S.curve.begin_s), S.curve.end_s);
  S.preview = null;
  if (S.draft < S.view[0] || S.draft > S.view[1]) { const half = (S.view[1] - S.view[0]) / 2; show(S.draft - half, S.draft + half); }
  draw();
  clearTimeout(settling);
  const name = S.trial, at = S.draft;
  say(`moved to ${plain(at, 6)} s: press a to accept it there, Esc to leave it`);
  settling = setTimeout(async () => {
    try {
      const found = await call("preview", { trial: name, pick_s: at });
      if (S.trial !== name || S.draft !== at) return;
      S.preview = found.picked;
      say(`at ${plain(at, 6)} s it would be ${symbol()} = ${withStd(found.picked[0], found.picked[1])}: press a to accept, Esc to leave it`);
      draw();
    } catch (error) { if (S.draft === at) say(`${plain(at, 6)} s: ${error.message}`); }
  }, 120);
}
const nudge = (pixels) => S.curve && moveTo(place() + pixels * (S.view[1] - S.view[0]) / scales().width);
function leave() { S.draft = S.preview = null; say(""); draw(); }

// --- decisions ---

function accept() {
  const row = S.rows.get(S.trial), trial = S.trial;
  if (!row || !S.info || S.info.trial !== trial) return null;
  const time = S.draft ?? (kindOf(row) === "ask" && S.info.candidates.length ? S.info.candidates[0].time_s : null);
  if (time !== null && !S.preview) {  // nothing is written before its force was seen
    moveTo(time);
    return null;
  }
  if (time !== null) return write("decide", { trial, action: "pick", pick_s: time }, `${trial}: accepted at ${plain(time, 6)} s, and written`);
  if (row.outcome === "kept") say(`${trial} counts as it is.`);
  else if (row.outcome === "rejected") say(`${trial} is rejected by the rule for outliers, which goes by the numbers.`);
  else say("There is no candidate: click where the break-away is, or exclude the trial.");
  return null;
}
async function acceptAndGoOn() {
  const trial = S.trial, done = accept();
  if (done) await done;
  else if (S.draft !== null) return;  // its force is yet to be seen
  if (S.trial === trial && $("error").hidden && kindOf(S.rows.get(trial)) !== "ask") step(1);
}
let asked = null;
function ask(action, what, text) {
  if (!S.trial) return;
  asked = { trial: S.trial, action };
  $("ask-what").textContent = what;
  $("ask-text").value = text;
  $("ask").showModal();
  $("ask-text").select();
}
function answerAsked() {
  const text = $("ask-text").value.trim();
  $("ask").close();
  if (asked) write("decide", { ...asked, text }, `${asked.trial}: written`);
  asked = null;
}
const exclude = () => ask("exclude", `Why is ${S.trial} excluded?`, S.rows.get(S.trial).excluded);
const comment = () => ask("comment", `Comment on ${S.trial}`, S.rows.get(S.trial).why.replace(/^review: /, ""));
const clear = () => isEnabled($("do-clear")) && write("decide", { trial: S.trial, action: "clear" }, `${S.trial}: left to the picker again`);
const undo = () => write("undo", {}, "undone: what held before holds again");

// --- keys, mouse, fingers ---

const KEYS = { j: () => step(1), n: () => step(1), ArrowDown: () => step(1), k: () => step(-1), p: () => step(-1), ArrowUp: () => step(-1),
  a: accept, Enter: acceptAndGoOn, x: exclude, c: comment, r: clear, u: undo, z: zoomAtPeak, w: whole, Escape: leave,
  "+": () => zoom(0.6), "-": () => zoom(1 / 0.6), "/": () => $("by-text").focus(),
  ArrowLeft: (event) => nudge(event.shiftKey ? -10 : -1), ArrowRight: (event) => nudge(event.shiftKey ? 10 : 1) };
addEventListener("keydown", (event) => {
  const on = event.target;
  if (event.ctrlKey || event.altKey || event.metaKey || $("ask").open || shown() !== "picks") return;
  if (on.matches("input, select")) { if (event.key === "Escape") $("list").focus(); return; }
  if (on.matches("button") && ["Enter", " "].includes(event.key)) return;
  const chosen = /^[1-9]$/.test(event.key) && S.info ? S.info.candidates[event.key - 1] : null;
  const act = chosen ? () => moveTo(chosen.time_s) : KEYS[event.key];
  if (!act || !S.trial) return;
  event.preventDefault();
  act(event);
});
for (const [id, act] of Object.entries({ accept, exclude, comment, clear, undo, zoom: zoomAtPeak, whole, previous: () => step(-1),
  next: () => step(1), left: () => nudge(-1), right: () => nudge(1) }))
  $(`do-${id}`).onclick = () => act();
$("ask-yes").onclick = answerAsked;
$("ask-no").onclick = () => $("ask").close();
$("ask-text").onkeydown = (event) => { if (event.key === "Enter") { event.preventDefault(); answerAsked(); } };
for (const id of ["by-status", "by-condition"]) $(id).onchange = filter;
$("by-order").onchange = () => { arrange(); filter(); };
$("by-text").oninput = filter;
$("list").onscroll = drawSeen;
$("list").onclick = (event) => { const row = event.target.closest(".row"); if (row) choose(row.dataset.trial); };
const plot = $("plot");
let held = null;
plot.onpointerdown = (event) => {
  if (!S.curve) return;
  held = { x: event.offsetX, view: S.view, moved: false };
  plot.setPointerCapture(event.pointerId);
};
plot.onpointermove = (event) => {
  if (!held || (!held.moved && Math.abs(event.offsetX - held.x) < 5)) return;
  held.moved = true;
  const by = (held.x - event.offsetX) / scales().width * (held.view[1] - held.view[0]);
  show(held.view[0] + by, held.view[1] + by);
};
plot.onpointerup = (event) => { if (held && !held.moved) moveTo(scales().time(event.offsetX)); held = null; };
plot.onpointercancel = () => { held = null; };
plot.ondblclick = whole;
plot.addEventListener("wheel", (event) => {
  event.preventDefault();
  if (S.curve) zoom(1.25 ** Math.sign(event.deltaY), scales().time(event.offsetX));
}, { passive: false });
new ResizeObserver(() => { if (shown() !== "picks") return; draw(); drawList(); if (S.curve) loadCurve(); }).observe($("figure"));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { if (shown() === "picks") draw(); });

declare("picks", async () => {
  const tree = await call("overview");
  take(tree);
  showAnswer(tree);
  const name = S.shown.includes(S.trial) ? S.trial : S.shown[0];
  if (name) await choose(name);
  $("list").focus({ preventScroll: true });
}, async () => { await readAgain(); say("the list was read again"); });
