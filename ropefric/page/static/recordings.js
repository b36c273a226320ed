// Step 1: a folder of recordings becomes a campaign, seen and corrected before it is written.
import { $, call, calm, enable, fail, fill, go, listed, make, plain, redraw as renew, refresh, shown, state, step, work } from "./frame.js";
import { chart } from "./canvas.js";

const ROLES = { time: "time", force: "force", end_tension: "end tension", counts: "counts", end_tension_counts: "counts of the end tension" };
const CELL = { full_scale: "1 kN", zero_voltage: "0 V", full_scale_voltage: "5 V", rated_output: "2 mV/V" };
const HEADERS = ["wheel", "wheel_radius_mm", "wrap_angle_deg", "wrap_turns", "end_tension_N", "end_mass_kg", "cell", "repeat", "*"];
const MOST_ROWS = 200, MOST_FILES = 5000;
// `data` are the settings of the campaign as its file states them; `campaign` is that file, "" for a new one.
const R = { told: null, names: null, scales: null, data: {}, campaign: null };
const text = (id) => $(id).value.trim();
// A column without a header of its own goes by its number: #3 in a field.
const columnText = (column) => typeof column === "number" ? `#${column}` : column ?? "";
const columnOf = (words) => /^#\d+$/.test(words) ? Number(words.slice(1)) : words;
const sizeOf = (round) => round?.radius !== undefined ? "radius" : "diameter";
const rateOf = () => R.data.sampling ? ["sampling", "rate"] : ["import", "sampling_rate"];

// --- the settings of a campaign that is there, in the fields ---

async function begin(anew) {
  R.data = await call("begin", {}, { anew });
  Object.assign(R, { told: null, campaign: state.campaign, trace: null });
  const editing = !anew && state.campaign !== "", { rope, tare, design, adc, import: own } = R.data;
  for (const id of ["r-place", "r-names"]) $(id).hidden = editing;
  $("r-there").hidden = $("r-more").hidden = !editing;
  $("r-write").textContent = editing ? "Write the changes and continue" : "Write the campaign and continue";
  $("r-rope-size").textContent = `${sizeOf(rope) === "radius" ? "Radius" : "Diameter"} of the rope`;
  const fields = { name: R.data.name, rope: rope?.[sizeOf(rope)], from: tare?.interval?.[0], until: tare?.interval?.[1],
    "design-radius": design?.wheel_radius, "design-wrap": design?.wrap_angle, "design-tension": design?.end_tension,
    "adc-bits": adc?.bits, "adc-low": adc?.low, "adc-high": adc?.high, rate: R.data[rateOf()[0]]?.[rateOf()[1]], pattern: "" };
  for (const [name, value] of Object.entries(fields)) $(`r-${name}`).value = value ?? "";
  choose($("r-format"), own?.format ?? "");
  choose($("r-recording_column"), columnText(own?.recording_column));
  $("r-channels").tBodies[0].replaceChildren();
  $("r-wheels").replaceChildren();
  // Of a campaign that is there the list names the cells; the last row takes one more.
  const cells = editing ? [...Object.entries(R.data.cells ?? {}), ["", {}]] : [["", { column: "cell" }], ["", { column: "end_cell" }]];
  fill($("r-cells"), ["cell", "measures", ...Object.keys(CELL).map((key) => key.replaceAll("_", " "))], cells.map(cellRow));
  $("r-electric").open = editing && (cells.length > 1 || Boolean(adc));
}
function choose(select, value) {
  if (![...select.options].some((one) => one.value === value)) select.append(new Option(value, value));
  select.value = value;
}
function cellRow([name, given], place) {
  const made = make("tr"), of = given.column === "end_cell" ? "end tension" : given.column ? "force" : "as in the list";
  const field = (key, value, example) => {
    const one = make("input"), cell = make("td");
    Object.assign(one, { value: value ?? "", placeholder: example, onchange: look, id: `r-cell-${place}-${key}`, readOnly: key === "name" && name !== "" });
    one.setAttribute("aria-label", `${key.replaceAll("_", " ")} of cell ${name || place + 1}`);
    cell.append(one);
    return cell;
  };
  made.dataset.column = given.column ?? "";
  made.append(field("name", name, `K${place + 1}`), make("td", of), ...Object.entries(CELL).map(([key, example]) => field(key, given[key], example)));
  return made;
}
const cellsOf = () => [...$("r-cells").tBodies[0].rows].map((row) => {
  const [name, ...values] = [...row.querySelectorAll("input")].map((one) => one.value.trim());
  return { name, column: row.dataset.column, keys: Object.fromEntries(Object.keys(CELL).map((key, place) => [key, values[place]])) };
}).filter((one) => one.name);

// --- the wish of a person ---

function wish() {
  const bits = text("r-adc-bits"), channels = {}, cells = {}, settings = { name: text("r-name"), rope: { [sizeOf(R.data.rope)]: text("r-rope") },
    tare: { interval: text("r-from") && text("r-until") ? [text("r-from"), text("r-until")] : "" },
    adc: { bits: Number(bits) || bits, low: text("r-adc-low"), high: text("r-adc-high") },
    design: { wheel_radius: text("r-design-radius"), wrap_angle: text("r-design-wrap"), end_tension: text("r-design-tension") },
    import: { format: text("r-format"), recording_column: columnOf(text("r-recording_column")) }, wheels: {}, cells: {} };
  const [table, rate] = rateOf();
  settings[table] = { ...settings[table], [rate]: text("r-rate") };
  for (const row of $("r-channels").tBodies[0].rows) {
    const [column, unit, sensitivity] = [...row.querySelectorAll("select, input")].map((one) => one.value.trim());
    channels[row.dataset.role] = { column: columnOf(column), unit: column && unit, sensitivity: column && sensitivity };
  }
  for (const field of $("r-wheels").querySelectorAll("input"))
    settings.wheels[field.dataset.wheel] = { [sizeOf(R.data.wheels?.[field.dataset.wheel] ?? { radius: "" })]: field.value.trim() };
  for (const one of cellsOf()) {
    settings.cells[one.name] = one.keys;
    if (one.column) cells[one.column] = one.name;
  }
  return { recordings: text("r-folder"), home: text("r-home"), pattern: isPattern() ? text("r-pattern") : "", channels, settings, cells };
}
const isPattern = () => /[{(]/.test($("r-pattern").value);

let looking = null, again = false;
export function look() {  // one look after the other; only the last result is shown
  if (looking) again = true;
  looking ??= (async () => {
    do {
      again = false;
      R.told = null;
      const told = await work("propose", wish());
      if (!again) { R.told = told; show(); }
    } while (again);
    await refresh();
  })().catch(fail).finally(() => { looking = null; });
  return looking;
}

// --- the result ---

function show() {
  const told = R.told, found = told.found, columnsOf = (name) => told.header.includes(name) ? told.rows.map((row) => row[told.header.indexOf(name)]) : [];
  const names = columnsOf("file").slice(0, MOST_FILES).map((file) => file.split("/").pop());
  $("r-more").hidden = false;
  if (!isPattern() && names.length) $("r-pattern").value = names[0].replace(/\.gz$/, "").replace(/\.[^.]*$/, "");
  showRows(told);
  $("r-read").textContent = found ? [found.file, found.read || found.stopped].filter(Boolean).join(": ") : told.said.join("; ");
  listed($("r-doubts"), found ? [...found.doubts, ...found.notes] : []);
  const columns = found ? found.columns.map((one) => {
    const unique = one.name && found.columns.filter((other) => other.name === one.name).length === 1;
    return [unique ? one.name : `#${one.number}`, one.name || `column ${one.number}`];
  }) : [];
  const select = (chosen) => {
    const made = make("select"), has = columns.some(([value]) => value === chosen);
    made.append(new Option("–", ""), ...columns.map(([value, words]) => new Option(words, value)), ...(chosen && !has ? [new Option(chosen, chosen)] : []));
    made.value = chosen;
    return made;
  };
  const rows = Object.entries(ROLES).map(([role, words]) => {
    const one = told.channels[role] ?? { column: "", unit: "", sensitivity: "" }, made = make("tr"), fields = [select(columnText(one.column)), make("input"), make("input")];
    fields[1].value = one.unit;
    fields[2].value = one.sensitivity;
    fields[2].placeholder = role === "time" ? "" : "25 N/mV";
    ["column", "unit", "sensitivity"].forEach((name, place) => {
      fields[place].setAttribute("aria-label", `${name} of the ${words}`);
      fields[place].id = `r-${role}-${name}`;
      fields[place].onchange = look;
    });
    made.dataset.role = role;
    made.append(...[make("th", words), ...fields].map((node) => { const cell = make("td"); cell.append(node); return cell; }));
    return made;
  });
  fill($("r-channels"), ["", "column", "unit", "sensitivity"], rows);
  const recording = $("r-recording_column"), chosen = recording.value;
  recording.replaceChildren(new Option("none", ""), ...columns.map(([value, words]) => new Option(words, value)));
  choose(recording, chosen);
  if (found) fill($("r-first"), found.columns.map((one) => one.name || `(${one.number})`), found.first_rows);
  const which = $("r-which"), at = which.value || "0";
  if (names.join("/") !== R.names) which.replaceChildren(...names.map((name, place) => new Option(name, place)));
  R.names = names.join("/");
  which.value = names[at] ? at : "0";
  showWheels([...new Set([...Object.keys(R.data.wheels ?? {}), ...columnsOf("wheel").filter(Boolean).sort()])]);
  showProblems(told.problems);
  const editing = !$("r-there").hidden, there = `${text("r-home")} has ${told.there.join(" and ")} already. You will see the changed lines before they are written.`;
  $("r-where").textContent = editing ? (told.difference ? "You will see the changed lines before they are written." : "No setting is changed.")
    : told.there.length ? there : `campaign.toml and trials.csv will be written into ${text("r-home")}.`;
  enable($("r-write"), (!editing || told.difference) && !told.problems.some((one) => one.severity === "error"));
  drawTrace();
}

function showRows({ header, rows }, missed = "") {
  fill($("r-rows"), header, rows.slice(0, MOST_ROWS));
  $("r-told").textContent = [`${rows.length} trials${rows.length > MOST_ROWS ? `, the first ${MOST_ROWS} are shown` : ""}`, missed].filter(Boolean).join("; ");
}

function showWheels(wheels) {
  const fields = $("r-wheels"), before = Object.fromEntries([...fields.querySelectorAll("input")].map((one) => [one.dataset.wheel, one.value]));
  renew(fields, ...wheels.map((name) => {
    const own = R.data.wheels?.[name], size = own ? sizeOf(own) : "radius";
    const label = make("label", `${size === "radius" ? "Radius" : "Diameter"} of wheel ${name} `), field = make("input");
    field.dataset.wheel = name;
    field.id = `r-wheel-${name}`;
    field.placeholder = "40 mm";
    field.value = before[name] ?? own?.[size] ?? "";
    field.onchange = look;
    label.append(field);
    return label;
  }));
}

// The key of a problem leads to the field that corrects it, which is marked.
function fieldOf({ key, fix }) {
  const [, wheel] = /\[wheels\.([^\]]+)\]/.exec(fix) ?? [];
  if (wheel && $(`r-wheel-${wheel}`)) return $(`r-wheel-${wheel}`);
  const [, table, name] = /^(?:import\.)?(channels|rope|tare|design|wheels|adc|cells)\.?([\w-]*)/.exec(key) ?? [];
  if (table === "channels") return $(`r-${name}-sensitivity`);
  if (table === "wheels") return $(`r-wheel-${name}`);
  const [, cell] = /under \[cells\.([^\]]+)\]/.exec(fix) ?? [];
  if (cell) return $(`r-cell-${Math.max(0, $("r-cells").tBodies[0].rows.length - 1)}-name`);
  if (table === "cells") return $(`r-cell-${Math.max(0, cellsOf().findIndex((one) => one.name === name))}-full_scale`);
  return { rope: $("r-rope"), tare: $("r-from"), design: $("r-design-radius"), adc: $("r-adc-bits") }[table] ?? (/wrap|tension|repeat|wheel/.test(key) ? $("r-pattern") : null);
}
function showProblems(problems) {
  for (const one of document.querySelectorAll("#r-more .missing")) { one.classList.remove("missing"); one.removeAttribute("aria-invalid"); }
  $("r-problems").replaceChildren(...problems.map((one) => {
    const field = fieldOf(one);
    if (field && one.severity === "error") { field.classList.add("missing"); field.setAttribute("aria-invalid", "true"); }
    return make("li", `${one.severity}: ${one.key ? `${one.key}: ` : ""}${one.message}${one.times > 1 ? ` (${one.times} times)` : ""}${one.fix ? ` – ${one.fix}` : ""}`, one.severity);
  }));
  if (problems.some((one) => /in counts|\[adc\]|\[cells\./.test(one.message + one.fix))) $("r-electric").open = true;
  if (!problems.length) $("r-problems").replaceChildren(make("li", "none"));
}

// --- the names ---

let settling = 0;
$("r-pattern").oninput = () => {
  clearTimeout(settling);
  if (!isPattern()) return;
  settling = setTimeout(async () => {
    try {
      const found = await call("names", { recordings: text("r-folder"), pattern: text("r-pattern") });
      showRows(found, found.said);
      calm();
    } catch (error) { $("r-told").textContent = error.message; }
  }, 150);
};
$("r-pattern").onchange = () => { if (isPattern()) look(); };
function mark(header) {
  const field = $("r-pattern"), [from, to] = [field.selectionStart, field.selectionEnd];
  field.setRangeText(header === "*" ? "*" : `{${header}}`, from, to, "end");
  field.focus();
  field.oninput();
}

// --- one recording, and the stretch of it that is unloaded ---

async function drawTrace() {
  const canvas = $("r-plot");
  try {
    R.trace = await call("trace", { number: text("r-which") || 0, columns: Math.max(50, canvas.clientWidth - 62) });
    redraw();
  } catch (error) {
    R.trace = R.scales = null;
    $("r-legend").textContent = `${error.message}${error.fix ? ` – ${error.fix}` : ""}`;
    canvas.getContext("2d").clearRect(0, 0, canvas.width, canvas.height);
  }
}
const seconds = (id) => { const found = /^([\d.eE+-]+)\s*(ms|s)?$/.exec(text(id)); return found ? found[1] * (found[2] === "ms" ? 1e-3 : 1) : NaN; };
function redraw() {
  if (!R.trace) return;
  const colors = ["s0", "s1"], { curves, units } = R.trace, shade = [seconds("r-from"), seconds("r-until")];
  const series = Object.entries(curves).map(([name, one], place) => ({ name, color: colors[place], thin: true,
    line: one.time_s.flatMap((t, i) => one.low_N[i] === one.high_N[i] ? [[t, one.low_N[i]]] : [[t, one.low_N[i]], [t, one.high_N[i]]]) }));
  R.scales = chart($("r-plot"), { series, x: "time [s]", y: `[${[...new Set(Object.values(units))].join(", ")}]`,
    shade: shade.every(Number.isFinite) ? shade : null });
  $("r-legend").replaceChildren(...Object.keys(curves).map((name, place) => {
    const said = make("span", `${ROLES[name]} [${units[name]}]`, `c${place}`);
    said.dataset.sign = "━";
    return said;
  }));
  $("r-plot").setAttribute("aria-label", `${R.trace.file}: ${Object.keys(curves).map((name) => ROLES[name]).join(" and ")} over time`);
}
let from = null;
const plot = $("r-plot");
plot.onpointerdown = (event) => { if (R.scales) { from = R.scales.at(event.offsetX); plot.setPointerCapture(event.pointerId); } };
plot.onpointermove = (event) => {
  if (from === null) return;
  const ends = [from, R.scales.at(event.offsetX)].map((t) => Math.min(Math.max(t, R.scales.begin), R.scales.end)).sort((a, b) => a - b);
  if (ends[1] === ends[0]) return;
  [$("r-from").value, $("r-until").value] = ends.map((t) => `${plain(t, 3)} s`);
  redraw();
};
plot.onpointerup = () => { if (from !== null && text("r-until")) look(); from = null; };
$("r-which").onchange = drawTrace;
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
new ResizeObserver(() => { if (shown() === "recordings") redraw(); }).observe(plot);

// --- files that are dropped ---

export async function upload(files) {
  let done = 0;
  try {
    for (const file of files) {
      if (file.size > state.largest_file) throw { message: `${file.name} is larger than ${state.largest_file / 2 ** 20} MB`, fix: "name the folder of the recordings instead" };
      $("r-dropped").textContent = `${done} of ${files.length} files, ${file.name}`;
      $("r-folder").value = (await call("upload", { name: file.name }, file)).recordings;
      done += 1;
    }
    $("r-dropped").textContent = `${done} files are in ${text("r-folder")}`;
    await look();
  } catch (error) { fail(error); }
}
$("r-files").onchange = () => upload([...$("r-files").files]);
const drop = $("r-drop");
drop.ondragover = (event) => { event.preventDefault(); drop.classList.add("over"); };
drop.ondragleave = () => drop.classList.remove("over");
drop.ondrop = (event) => { event.preventDefault(); drop.classList.remove("over"); upload([...event.dataTransfer.files]); };
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => event.preventDefault());  // a file that misses its place does not take the page's

// --- writing ---

async function write() {
  try {
    await look();
    if (!R.told || R.told.problems.some((one) => one.severity === "error")) return;
    const { there, difference, shown: seen } = R.told;
    if (there.length && !await mayReplace(there, difference)) return;
    await call("write", {}, { shown: seen, overwrite: there.length > 0 });
    R.campaign = null;  // it is read again when this step is shown again
    await work("open", {});
    await refresh();
    go("picks");
  } catch (error) { fail(error); }
}
function mayReplace(there, difference) {
  const asked = $("replace");
  $("replace-what").textContent = `These lines of ${there.join(" and ")} change:`;
  $("replace-lines").textContent = difference || "none";
  asked.returnValue = "";
  asked.showModal();
  return new Promise((answer) => { asked.onclose = () => answer(asked.returnValue === "yes"); });
}
$("replace-yes").onclick = () => $("replace").close("yes");
$("replace-no").onclick = () => $("replace").close();
$("r-anew").onclick = async () => {
  try { await begin(true); if (state.recordings) await look(); } catch (error) { fail(error); }
};
$("r-write").onclick = write;
$("r-check").onclick = look;
$("r-form").onsubmit = (event) => { event.preventDefault(); look(); };
for (const id of ["r-format", "r-recording_column", "r-rate", "r-name", "r-rope", "r-from", "r-until", "r-design-radius", "r-design-wrap", "r-design-tension",
  "r-adc-bits", "r-adc-low", "r-adc-high"])
  $(id).onchange = look;

step("recordings", async () => {
  if (!$("r-headers").children.length) {
    $("r-headers").append(...HEADERS.map((name) => {
      const button = make("button", name === "*" ? "anything" : name.replaceAll("_", " "));
      button.type = "button";
      button.onmousedown = (event) => event.preventDefault();  // the mark in the pattern stays
      button.onclick = () => mark(name);
      return button;
    }));
  }
  $("r-home").value ||= state.home;
  $("r-folder").value ||= state.recordings;
  if (R.campaign !== state.campaign) await begin(false);
  if ((state.recordings || state.campaign) && !R.told) look(); else if (R.told) redraw();
}, async () => { await begin(false); await look(); });
