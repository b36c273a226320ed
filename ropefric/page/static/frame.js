// What all steps share: what goes over the line, long work, words and numbers, and which step is shown.
export const $ = (id) => document.getElementById(id);

// --- what goes over the line ---

const given = new URLSearchParams(location.search).get("token");
if (given) {
  sessionStorage.setItem("token", given);
  history.replaceState(null, "", location.pathname + location.hash);  // no token stays in sight, or in the history
}
export const token = () => sessionStorage.getItem("token") || "";

export async function call(path, query = {}, body = null) {
  const options = { headers: { "X-Ropefric-Token": token() } };
  if (body) {
    options.method = "POST";
    options.body = body instanceof Blob ? body : JSON.stringify(body);
    options.headers["Content-Type"] = body instanceof Blob ? "application/octet-stream" : "application/json";
  }
  let answer, tree;
  try {
    answer = await fetch(`/api/${path}?${new URLSearchParams(query)}`, options);
    tree = await answer.json();
  } catch {
    throw { message: "ropefric does not answer; it may have ended", fix: "written files are safe; start `ropefric app` again" };
  }
  if (tree.error) throw { ...tree.error, status: answer.status };
  return tree;
}

// --- words, numbers and rows ---

export const known = (x) => x !== null && x !== undefined;
export const plain = (x, digits = 4) => known(x) ? String(+x.toPrecision(digits)) : "–";
export const unit = (x, name, digits = 4) => known(x) ? `${plain(x, digits)} ${name}` : "–";
export const places = (std) => Math.min(9, Math.max(0, 1 - Math.floor(Math.log10(std))));
export function withStd(x, std, name = "N") {
  return known(x) && std ? `${x.toFixed(places(std))} ± ${std.toFixed(places(std))} ${name}` : unit(x, name, 5);
}
export function withEnds(x, [low, high], name = "N") {
  const at = known(low) && known(high) && high > low ? places((high - low) / 4) : 2;
  return known(x) ? `${x.toFixed(at)} ${name} [${low?.toFixed(at) ?? "–"}, ${high?.toFixed(at) ?? "–"}]` : "–";
}
export function make(tag, text = "", kind = "") {
  const made = document.createElement(tag);
  made.textContent = text;
  if (kind) made.className = kind;
  return made;
}
export function tableRow(cells, tag = "td") {
  const made = make("tr");
  made.append(...cells.map((cell) => cell instanceof Node ? cell : make(tag, cell)));
  return made;
}
// A button that can do nothing now stays in reach: one that is `disabled` would lose the focus.
export const enable = (button, is) => button.setAttribute("aria-disabled", String(!is));
export const isEnabled = (button) => button.getAttribute("aria-disabled") !== "true";
addEventListener("click", (event) => {
  const button = event.target.closest("button");
  if (button && !isEnabled(button)) { event.preventDefault(); event.stopImmediatePropagation(); }
}, true);

const CONTROLS = "button, input, select, a[href]";
// New content for a place of the page; the control that has the focus keeps it, by its id or else by its place.
export function redraw(place, ...content) {
  const on = document.activeElement, n = place.contains(on) ? [...place.querySelectorAll(CONTROLS)].indexOf(on) : -1;
  place.replaceChildren(...content);
  if (n >= 0) (on.id && $(on.id) || place.querySelectorAll(CONTROLS)[n])?.focus({ preventScroll: true });
}
export function fill(table, head, rows) {
  table.tHead.replaceChildren(tableRow(head, "th"));
  redraw(table.tBodies[0], ...rows.map((cells) => cells instanceof Node ? cells : tableRow(cells)));
}
export const listed = (list, words) => list.replaceChildren(...words.map((one) => make("li", one)));

export function fail(error) {
  if (error.status === 403) return askToken(error.message);
  $("why").textContent = `${error.code ? `${error.code}: ` : ""}${error.message || error}`;
  $("fix").textContent = error.fix ? `Remedy: ${error.fix}` : "";
  $("do-reload").hidden = error.code !== "RF153" || !reloads[now];
  $("error").hidden = false;
  return null;
}
export const calm = () => { $("error").hidden = true; };
$("do-hide").onclick = calm;

function askToken(why) {
  $("token-why").textContent = why;
  if (!$("token").open) $("token").showModal();
}
$("token-yes").onclick = () => { sessionStorage.setItem("token", $("token-text").value.trim()); location.reload(); };
$("token-text").onkeydown = (event) => { if (event.key === "Enter") $("token-yes").click(); };

// --- long work: how far it is, and the end of it ---

export async function work(path, body) {
  calm();
  let told = body === null ? await call("work") : (await call(path, {}, body)).work;
  if (body === null && !told.running) return null;
  try {
    for (;;) {
      $("work").hidden = !told.running;
      $("work-said").textContent = `${told.name} ${told.total ? `${told.done} of ${told.total}` : ""} ${told.item}`;
      if (told.total) $("work-bar").value = told.done / told.total; else $("work-bar").removeAttribute("value");
      if (!told.running) break;
      await new Promise((go) => { setTimeout(go, 250); });
      told = await call("work");
    }
  } finally { $("work").hidden = true; }
  if (told.error) throw told.error;
  return told.result;
}
$("work-stop").onclick = () => call("stop", {}, {}).catch(fail);

// --- the steps ---

const opens = {}, reloads = {};
let now = "";
export const state = {};
export const shown = () => now;
export const step = (name, open, reload) => { opens[name] = open; reloads[name] = reload; };
$("do-reload").onclick = async () => {  // what somebody else has changed
  try { calm(); await reloads[now](); } catch (error) { fail(error); }
};
export async function readAgain() {
  await work("open", {});
  await refresh();
  await opens[now]();
}

export async function refresh() {
  Object.assign(state, await call("state"));
  $("campaign").textContent = state.name || "ropefric";
  $("target").textContent = state.campaign || state.home;
  document.title = state.name ? `${state.name}: ropefric` : "ropefric";
  for (const link of document.querySelectorAll("nav a")) {
    const is = state.ready || link.dataset.free !== undefined;
    link.setAttribute("aria-disabled", String(!is));
  }
}

export function go(name) {
  if (location.hash === `#${name}`) return open();
  location.hash = name;
  return null;
}
async function open() {
  const link = document.querySelector(`nav a[href="${location.hash}"]`);
  if (!link || link.getAttribute("aria-disabled") === "true") return location.replace(state.ready ? "#picks" : "#recordings");
  now = location.hash.slice(1);
  for (const one of document.querySelectorAll("nav a")) {
    if (one === link) one.setAttribute("aria-current", "step"); else one.removeAttribute("aria-current");
    $(`step-${one.hash.slice(1)}`).hidden = one !== link;
  }
  document.body.dataset.step = now;
  if (!document.activeElement.closest("nav, dialog")) $(`step-${now}`).focus({ preventScroll: true });  // what had the focus is hidden
  try { await opens[now](); } catch (error) { fail(error); }
}
addEventListener("hashchange", open);
addEventListener("keydown", (event) => {
  const place = event.altKey && !event.ctrlKey ? Number(event.key) : 0, link = document.querySelectorAll("nav a")[place - 1];
  if (link) { event.preventDefault(); go(link.hash.slice(1)); }
});
