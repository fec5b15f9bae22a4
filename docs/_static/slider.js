// A picture of cells side by side whose name ends in "maps.svg" is shown one cell at a time, below a slider. Its alternative
// text names the voltage of each cell. Without scripts all cells are seen.
document.querySelectorAll('img[src$="maps.svg"]').forEach((picture) => {
  const labels = picture.alt.match(/\d+ V/g);
  const slider = Object.assign(document.createElement("input"), {
    type: "range", min: 0, max: labels.length - 1, value: labels.length - 1,
  });
  slider.setAttribute("aria-label", "voltage");
  const told = document.createElement("output");
  const cell = document.createElement("div");
  cell.className = "cell";
  picture.replaceWith(slider, told, cell);
  cell.append(picture);
  picture.style.width = `${100 * labels.length}%`;
  const show = () => {
    const place = Number(slider.value);
    picture.style.transform = `translateX(${(-100 * place) / labels.length}%)`;
    slider.setAttribute("aria-valuetext", labels[place]);
    told.textContent = labels[place];
  };
  slider.addEventListener("input", show);
  show();
});
