// The beginning: the steps, and the campaign that exists already.
import { fail, go, refresh, state, work } from "./frame.js";
import "./recordings.js";
import "./picks.js";
import "./law.js";
import "./wheel.js";
import "./machine.js";
import "./report.js";

try {
  await refresh();
  await work("work", null);  // what went on before the page was loaded anew
  if (state.campaign && !state.ready) await work("open", {});
  await refresh();
  if (!location.hash || (location.hash !== "#wheel" && !state.ready)) history.replaceState(null, "", state.ready ? "#picks" : "#recordings");
  await go(location.hash.slice(1));
} catch (error) {
  fail(error);
  if (error.status !== 403) await go("recordings");
}
