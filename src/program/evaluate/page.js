// Enlarges a picture over its source, and hides lines of plots.
"use strict";
const large = document.getElementById("large");
const [under, over] = large.querySelectorAll("img");
const range = large.querySelector("input");
const stage = large.querySelector(".stage");
let shown = null;

function show(figure) {
  const figures = [...figure.parentElement.children];
  const [source] = figures;
  shown = figure;
  under.src = figure.querySelector("img").src;
  over.src = source.querySelector("img").src;
  stage.classList.toggle("alone", figure === source);
  large.querySelector("b").textContent = figure.querySelector("b").textContent;
  large.querySelector("span").textContent = figure.querySelector("span").textContent;
}

function go(step) {
  const figures = [...shown.parentElement.children];
  show(figures[(figures.indexOf(shown) + step + figures.length) % figures.length]);
}

const slide = () => stage.style.setProperty("--at", range.value / 10 + "%");
range.addEventListener("input", slide);

for (const figure of document.querySelectorAll(".pictures figure")) {
  figure.tabIndex = 0;
  figure.setAttribute("role", "button");
  const open = () => { show(figure); slide(); large.showModal(); range.focus(); };
  figure.addEventListener("click", open);
  figure.addEventListener("keydown", (event) => { if (event.key === "Enter") open(); });
}

large.addEventListener("click", (event) => {
  const step = event.target.dataset.go;
  if (event.target === large || step === "0") large.close();
  else if (step) go(Number(step));
});
// Before the range takes the keys.
large.addEventListener("keydown", (event) => {
  const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (!step) return;
  event.preventDefault();
  go(step);
}, true);

for (const name of document.querySelectorAll(".legend [data-name]")) {
  name.addEventListener("click", () => {
    const hidden = !name.classList.contains("off");
    const same = CSS.escape(name.dataset.name);
    for (const other of document.querySelectorAll(`.legend [data-name="${same}"]`)) other.classList.toggle("off", hidden);
    for (const line of document.querySelectorAll(`[data-line="${same}"]`)) line.style.display = hidden ? "none" : "";
  });
}
