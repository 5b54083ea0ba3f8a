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
explorer.heard.push((told) => { if (told.numbers) show_numbers(told.numbers); });
