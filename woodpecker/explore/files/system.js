// What the page of a system of contacts has of its own: its numbers, and what is being worked out.
"use strict";
function show_numbers(numbers) {
  $("#numbers").replaceChildren(...Object.entries(numbers).flatMap(([name, value]) => {
    const term = document.createElement("dt"), told = document.createElement("dd");
    term.textContent = name;
    told.id = "number-" + name;
    told.textContent = value === null ? "none" : value.toPrecision(8) + (name === "period" ? " s" : "");
    return [term, told];
  }));
}
explorer.heard.push((told) => {
  for (const name of ["order", "steps", "over", "coordinate", "start"]) {
    const element = $("#" + name);
    if (told[name] !== undefined && document.activeElement !== element) element.value = told[name];
  }
  if (told.periodic !== undefined) $("#periodic").checked = told.periodic;
  if (told.numbers) show_numbers(told.numbers);
  if (told.busy !== undefined) write("#busy", told.busy ? "working …" : "");
  if (told.stage !== undefined) { write("#stage", told.stage); $("#stop").disabled = !told.running; }
  if (told.branches) $("#branch").replaceChildren(new Option("no branch", ""), ...told.branches.map(({ id, text }) => new Option(text, id)));
  if (told.branch !== undefined) $("#branch").value = told.branch;
});
