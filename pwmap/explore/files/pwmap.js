// What the page of a map has of its own: the map that is typed, and lists of exact values.
"use strict";
$("#typed").addEventListener("submit", (event) => {
  event.preventDefault();
  const values = Object.entries(explorer.values).map(([name, value]) => [`at_${name}`, value]);
  location.search = new URLSearchParams([["map", $("#formula").value.trim()], ["given", $("#given").value.trim()], ...values]);
});
function show_rows(lists) {
  $("#rows").replaceChildren(...lists.filter((list) => list.rows.length).flatMap(({ title, rows }) => {
    const heading = document.createElement("h3"), table = document.createElement("table");
    heading.textContent = title;
    for (const row of rows) {
      const line = table.insertRow();
      for (const text of row) line.insertCell().textContent = text;
    }
    return [heading, table];
  }));
}
explorer.heard.push((told) => {
  if (told.rows) show_rows(told.rows);
  if (told.chaotic !== undefined) {
    write("#density-told", told.chaotic ? "" : "nothing chaotic attracts here");
    $("#view-density").classList.toggle("empty", !told.chaotic);
  }
  if (told.axes) {
    const none = !told.axes.length;
    write("#plane-told", none ? "a plane needs a map with two parameters" : "click: the map there");
    $("#view-plane").classList.toggle("empty", none);
    for (const part of $$("#view-plane label")) part.hidden = none;
    for (const [k, name] of ["across", "along"].entries()) write(`#name-${name}`, told.axes[k] ?? "");
  }
});
