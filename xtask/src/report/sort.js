// Tables are sorted by a click on a column's head: numbers as numbers, the largest first; texts by their letters.
document.querySelectorAll("table.sortable").forEach((table) => {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    head.querySelector("button").addEventListener("click", () => {
      const isNumber = head.classList.contains("number");
      const key = (row) => {
        const cell = row.cells[column];
        const text = cell.dataset.key ?? cell.textContent;
        if (!isNumber) return cell.dataset.key === undefined ? text : Number(text);
        const number = text === "inf" ? Infinity : Number(text);
        return text === "" || Number.isNaN(number) ? -1 : number;
      };
      const first = head.getAttribute("aria-sort") ? head.getAttribute("aria-sort") === "ascending" : isNumber;
      const sign = first ? -1 : 1;
      const rows = [...table.tBodies[0].rows].map((row, index) => [key(row), index, row]);
      rows.sort(([a, i], [b, j]) => (a < b ? -sign : a > b ? sign : i - j));
      table.tBodies[0].append(...rows.map(([, , row]) => row));
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", sign < 0 ? "descending" : "ascending");
    });
  });
});
