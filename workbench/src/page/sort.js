// Headings of tables as buttons that sort the rows: rising, falling, as they were. Rows without a value come last. Without this script the
// tables stand as they are.
"use strict";
for (const table of document.querySelectorAll(".scroll > table:not(.matrix)")) {
  const body = table.tBodies[0], rows = [...body.rows], headings = [...table.querySelectorAll("thead th")];
  if (3 > rows.length) continue;
  headings.forEach((heading, column) => {
    const text = (row) => row.cells[column]?.textContent.trim() ?? "";
    const number = (row) => parseFloat(text(row).replace(/^[\u003c\u003e≤≥±≈\s]+/, "").replaceAll(",", ""));
    const filled = rows.filter(text), empty = rows.filter((row) => !text(row));
    const button = document.createElement("button");
    button.type = "button";
    button.append(...heading.childNodes);
    heading.append(button);
    button.addEventListener("click", () => {
      const next = { ascending: "descending", descending: null }[heading.ariaSort];
      const order = next === undefined ? "ascending" : next;
      for (const other of headings) other.ariaSort = null;
      heading.ariaSort = order;
      const numeric = filled.every((row) => Number.isFinite(number(row)));
      const rising = numeric
        ? [...filled].sort((a, b) => number(a) - number(b))
        : [...filled].sort((a, b) => text(a).localeCompare(text(b), undefined, { numeric: true }));
      if (order === "descending") rising.reverse();
      body.append(...(order === null ? rows : [...rising, ...empty]));
    });
  });
}
