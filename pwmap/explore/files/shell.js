// The page's side of the letters: wishes go out one at a time, answers come back.
"use strict";
const $ = (query) => document.querySelector(query);
const $$ = (query) => [...document.querySelectorAll(query)];
const explorer = window.explorer = {
  ready: false, values: {}, defaults: {}, query: "", count: 0, sent: 0, waiting: null, next: null,
  times: [], shown: {}, heard: [], doc: null, answer: {},
  // Send a wish, or keep it until the last one is answered; a later one of the same kind replaces it.
  ask(wish) {
    wish.at = wish.at ?? performance.now();
    if (!this.ready || this.waiting) {
      const merges = this.next && this.next.do === "set" && wish.do === "set";
      if (this.next && !merges) this.rest.push(this.next);
      if (merges) wish.values = { ...this.next.values, ...wish.values };
      this.next = wish;
      return;
    }
    this.waiting = { ...wish, n: ++this.sent };
    this.model("wish").text = JSON.stringify(this.waiting);
  },
  rest: [],
  models: {},
  model(name) { return (this.models[name] ??= this.doc.get_model_by_name(name)); },
  answered(text) {
    const told = JSON.parse(text);
    this.count = told.count;
    this.answer = { ...this.answer, ...told };
    if (told.tables) sketch.take(told.tables, this.model("answer").numbers);
    else sketch.end();
    if (told.message !== undefined) write("#message", told.message);
    if (told.values) { this.values = told.values; show_values(told.values); }
    if (told.query !== undefined && !this.waiting?.drag) {
      this.query = told.query;
      history.replaceState(null, "", told.query ? "?" + told.query : location.pathname);
      if (parent !== window) parent.postMessage({ query: told.query, name: window.name }, location.origin);
      for (const each of $$("a.export")) each.href = `export/${each.dataset.file}?${told.query}`;
    }
    for (const listener of this.heard) listener(told);
    if (this.waiting && told.n === this.waiting.n) {
      const { at, drag } = this.waiting;
      this.waiting = null;
      requestAnimationFrame(() => setTimeout(() => drag && this.times.push(performance.now() - at)));
      const next = this.rest.shift() ?? this.next;
      if (next === this.next) this.next = null;
      if (next) this.ask(next);
    }
  },
};

// Nothing of the page is touched that stays as it is: whatever is touched is laid out anew.
function write(query, text) {
  const element = $(query);
  if (element.textContent !== text) element.textContent = element.title = text;
}
function show_values(values) {
  for (const control of CONTROLS) {
    const value = values[control.name];
    if (value === undefined) continue;
    const slider = $("#slider-" + control.name), field = $("#field-" + control.name);
    const number = typeof value === "string" ? quotient(value) : value;
    if (explorer.shown[control.name] === value) continue;
    explorer.shown[control.name] = value;
    if (document.activeElement !== slider || !dragging) slider.value = number;
    if (document.activeElement !== field) {
      field.value = typeof value === "string" ? value : +value.toPrecision(9);
      field.classList.toggle("changed", String(value) !== String(control.default) && number !== quotient(control.default));
    }
  }
}
const quotient = (text) => { const [a, b] = String(text).split("/"); return b ? a / b : +a; };

let dragging = false;
for (const slider of $$("#sliders input[type=range]")) {
  slider.addEventListener("input", () => {
    dragging = true;
    explorer.ask({ do: "set", values: { [slider.dataset.name]: +slider.value }, drag: true });
  });
  slider.addEventListener("change", () => {
    dragging = false;
    explorer.ask({ do: "set", values: { [slider.dataset.name]: +slider.value } });
  });
}
for (const field of $$("#sliders input[type=text]")) {
  const exact = CONTROLS.find((each) => each.name === field.dataset.name).exact;
  field.addEventListener("change", () => {
    const value = exact ? field.value.trim() : Number(field.value.replace(",", "."));
    explorer.ask({ do: "set", values: { [field.dataset.name]: exact ? value : Number.isNaN(value) ? field.value : value } });
    delete explorer.shown[field.dataset.name];
    field.blur();
  });
}
for (const button of $$(".back")) button.addEventListener("click", () => explorer.ask({ do: "back", name: button.dataset.name }));
// Everything with data-ask sends its verb; what it has of a value goes with it.
for (const each of $$("[data-ask]")) {
  const kind = each.matches("select, input") ? "change" : "click";
  each.addEventListener(kind, () => {
    const typed = each.inputMode === "decimal" ? each.value.replace(",", ".") : each.value;
    const value = each.type === "checkbox" ? each.checked : typed;
    explorer.ask({ do: each.dataset.ask, value: each.dataset.value ?? value });
  });
}
$("#reset").addEventListener("click", () => explorer.ask({ do: "reset" }));
$("#undo").addEventListener("click", () => explorer.ask({ do: "undo" }));
$("#link").addEventListener("click", () => {
  navigator.clipboard?.writeText(location.href).catch(() => {});
  tell("Link", location.href);
});
$("#compare").addEventListener("click", () => {
  open("compare?" + new URLSearchParams({ a: explorer.query, b: explorer.query }), "_blank");
});
$("#python").addEventListener("click", () => tell("Lines of Python", explorer.answer.python ?? ""));
$("#copy").addEventListener("click", () => navigator.clipboard?.writeText($("#dialog pre").textContent).catch(() => {}));
function tell(title, text) {
  $("#dialog h2").textContent = title;
  $("#dialog pre").textContent = text;
  $("#dialog").showModal();
}
for (const button of $$(".enlarge")) button.addEventListener("click", () => {
  explorer.ask({ do: "focus", value: explorer.answer.focus === button.value ? "" : button.value });
});
// Fields show what the answer tells under their names; a select may wait for its list.
explorer.heard.push((told) => {
  if (told.branches) {
    const list = JSON.stringify(told.branches);
    if (explorer.listed !== list) $("#branch").replaceChildren(new Option("no branch", ""), ...told.branches.map(({ id, text }) => new Option(text, id)));
    explorer.listed = list;
  }
  for (const each of $$("[data-ask][id]")) {
    const value = told[each.id];
    if (value === undefined || (document.activeElement === each && each.matches("input"))) continue;
    if (each.type === "checkbox") each.checked = value;
    else each.value = typeof value === "number" ? +value.toPrecision(10) : value;
  }
  if (told.stage !== undefined && $("#stage")) write("#stage", told.stage);
  if (told.running !== undefined && $("#stop")) $("#stop").disabled = !told.running;
  if (told.busy !== undefined) write("#busy", told.busy ? "working …" : "");
});
explorer.heard.push((told) => {
  if (told.focus === undefined) return;
  $("#views").classList.toggle("focused", told.focus !== "");
  for (const view of $$(".view")) view.classList.toggle("large", view.id === "view-" + told.focus);
});
addEventListener("click", (event) => {
  for (const menu of $$(".menu[open]")) if (!menu.contains(event.target) || event.target.matches("a.export, #python")) menu.open = false;
});
addEventListener("keydown", (event) => { if (event.key === "Escape") for (const menu of $$(".menu[open]")) menu.open = false; });

// A finger does not hover: a figure hears of a pointer where it was tapped, and says what is there.
addEventListener("pointerup", (event) => {
  if (event.pointerType !== "touch") return;
  const { clientX, clientY } = event, figure = event.composedPath()[0];
  const moved = { clientX, clientY, pointerType: "mouse", isPrimary: true, bubbles: true, composed: true };
  setTimeout(() => figure.dispatchEvent(new PointerEvent("pointermove", moved)));
});

// Bokeh asks the browser for a style of CSS before every stroke, in case a page themes it so, and for
// the size of a font, which is that of shell.css. To answer it the browser lays out the page each time.
try {
  Bokeh.require("core/visuals/visual").VisualProperties.prototype._get_css_value = () => "";
  Object.defineProperty(Bokeh.require("models/plots/plot_canvas").PlotView.prototype, "base_font_size", { get: () => 13 });
} catch { /* another version: only slower */ }

// Begin when the document is there; after a lost session load the page again: the link holds the state.
(function begin() {
  const doc = window.Bokeh?.documents?.[0];
  const answer = doc?.get_model_by_name("answer");
  if (!answer) { setTimeout(begin, 20); return; }
  explorer.doc = doc;
  answer.properties.text.change.connect(() => explorer.answered(answer.text));
  if (answer.text) explorer.answered(answer.text);
  doc.on_event("connection_lost", () => { $("#connection").hidden = false; explorer.lost = performance.now(); });
  doc.on_event("client_reconnected", () => {
    $("#connection").hidden = true;
    explorer.waiting = explorer.next = null;
    const count = explorer.count;
    explorer.ask({ do: "hello" });
    setTimeout(() => { if (explorer.count === count) location.reload(); }, 2500); // another server, which knows nothing
  });
  setInterval(async () => {
    if ($("#connection").hidden || performance.now() - explorer.lost < 3000) return;
    try { if ((await fetch(location.href, { cache: "no-store" })).ok) location.reload(); } catch { /* not yet */ }
  }, 1500);
  explorer.ready = true;
  explorer.ask({ do: "hello" });
})();
