// Step 4, second half: the templates of machines as forms made of what their keys declare, solved as one types.
import { $, call, fail, fill, make, plain, state } from "./frame.js";

const M = { fields: [] };

export async function showMachines() {
  $("m-own-label").hidden = !state.ready;
  if ($("m-which").options.length) return;
  try {
    const names = await call("machines");
    $("m-which").append(...names.map((one) => new Option(`${one.name} (${one.system})`, one.name)));
    $("m-which").value = "hoist";
    await form();
  } catch (error) { fail(error); }
}

async function form() {
  M.fields = await call("machine", { name: $("m-which").value });
  const rows = M.fields.filter((one) => !["system", "effects"].includes(one.key)).map((one) => {
    const label = make("label", one.key), field = make(one.choices?.length ? "select" : "input");
    if (one.choices?.length) field.append(new Option("–", ""), ...one.choices.map((word) => new Option(word, word)));
    if (one.choices?.length && one.value && !one.choices.includes(one.value)) field.append(new Option(one.value, one.value));
    field.value = one.value;
    field.dataset.key = one.key;
    field.placeholder = one.default && one.default !== "needed" ? one.default : (one.example ?? "").replaceAll('"', "");
    field.oninput = soon;
    const said = [one.meaning, one.unit && one.unit !== "-" ? `[${one.unit}]` : "", one.allowed ? `(${one.allowed})` : ""].filter(Boolean).join(" ");
    label.append(field, make("small", said));
    return [one.value !== "", label];
  });
  $("m-fields").replaceChildren(...rows.filter(([is]) => is).map(([, node]) => node));
  $("m-rest").replaceChildren(...rows.filter(([is]) => !is).map(([, node]) => node));
  await solve();
}

let settling = 0, number = 0;
function soon() {
  clearTimeout(settling);
  settling = setTimeout(solve, 250);
}
async function solve() {
  const own = $("m-own").checked, values = {}, mine = ++number;
  for (const field of $("m-form").querySelectorAll("[data-key]")) {
    const was = M.fields.find((one) => one.key === field.dataset.key).value;
    if (field.value.trim() !== was && !(own && field.dataset.key.startsWith("friction."))) values[field.dataset.key] = field.value;
  }
  try {
    const told = await call("solve", {}, { name: $("m-which").value, values, own });
    if (mine !== number) return;
    $("m-said").textContent = told.computing ? `computing (${told.computing})` : "";
    if (told.computing) { setTimeout(solve, 500); return; }
    $("m-answer").textContent = told.text;
    fill($("m-effects"), ["effect", "used", "largest influence", "why"], told.effects.map((one) =>
      [one.name, one.fate, one.worth === null ? "–" : `${plain(100 * one.worth, 2)} %`, one.why]));
  } catch (error) {
    if (mine !== number) return;
    $("m-said").textContent = `${error.message}${error.fix ? ` – ${error.fix}` : ""}`;
  }
}
$("m-which").onchange = () => form().catch(fail);
$("m-own").onchange = solve;
$("m-form").onsubmit = (event) => event.preventDefault();
