// A cursor on each figure that says the values under it; a stretch that is dragged over fills the figure, a double click
// takes it back. With the keyboard the arrows move the cursor, + and - enlarge around it, Escape takes it back. Without this script
// the figures stand as they are.
"use strict";
for (const figure of document.querySelectorAll("figure[data-plot]")) {
  const { left, right, top, bottom, across, up, labels, axes } = JSON.parse(figure.dataset.plot);
  const svg = figure.querySelector("svg"), said = figure.querySelector("output");
  const make = (name, attributes, parent) => {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    return parent.appendChild(made);
  };
  const lines = [...svg.querySelectorAll("polyline")].filter((line) => line.points.numberOfItems > 2);
  const shades = [...svg.querySelectorAll('rect[fill="var(--shade)"], polygon')];
  const ticks = [...svg.querySelectorAll("text")]
    .filter((text) => +text.getAttribute("y") > bottom)
    .filter((text) => Number.isFinite(parseFloat(text.textContent)));
  const first = ticks.map((tick) => tick.textContent);
  const clip = `clip-${figure.id}`;
  make("rect", { x: left, y: top, width: right - left, height: bottom - top },
    make("clipPath", { id: clip }, svg));
  const inside = make("g", { "clip-path": `url(#${clip})` }, svg);
  for (const part of [...shades, ...lines]) {
    part.setAttribute("vector-effect", "non-scaling-stroke");
    inside.append(part);
  }
  const dots = lines.map((line) => make("circle", { r: 4, fill: line.getAttribute("stroke"), opacity: 0 }, svg));
  const brush = make("rect", { y: top, height: bottom - top, width: 0, fill: "var(--ink)", opacity: 0.12 }, svg);
  let scale = 1, shift = 0, start = null, cursor = (left + right) / 2;
  svg.setAttribute("tabindex", 0);
  const value = (x) => across[0] + ((x - shift) / scale - left) / (right - left) * (across[1] - across[0]);
  const height = (y) => up[0] + (bottom - y) / (bottom - top) * (up[1] - up[0]);
  const place = (event) => new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  const show = (number) => Number(number.toPrecision(4)).toString();
  const draw = () => {
    for (const part of [...shades, ...lines]) part.setAttribute("transform", `matrix(${scale} 0 0 1 ${shift} 0)`);
    ticks.forEach((tick, k) => {
      tick.textContent = scale === 1 ? first[k] : show(value(+tick.getAttribute("x")));
    });
  };
  const read = (at) => {
    cursor = at.x;
    const words = lines.map((line, k) => {
      let best = null, least = Infinity;
      for (const point of line.points) {
        const far = Math.abs(point.x * scale + shift - at.x) + 0.2 * Math.abs(point.y - at.y);
        if (least > far) [best, least] = [point, far];
      }
      dots[k].setAttribute("cx", best.x * scale + shift);
      dots[k].setAttribute("cy", best.y);
      dots[k].setAttribute("opacity", 1);
      return `${labels[k]} ${show(height(best.y))}`;
    });
    said.textContent = `${axes[0]} ${show(value(at.x))}: ${words.join(", ")}`;
  };
  const fill = (from, to) => {
    scale = (right - left) / (to - from);
    shift = left - from * scale;
    draw();
  };
  const whole = () => {
    [scale, shift] = [1, 0];
    draw();
  };
  svg.addEventListener("pointermove", (event) => {
    const at = place(event);
    if (start !== null) {
      brush.setAttribute("x", Math.min(start, at.x));
      brush.setAttribute("width", Math.abs(at.x - start));
    }
    read(at);
  });
  svg.addEventListener("pointerdown", (event) => {
    start = place(event).x;
  });
  svg.addEventListener("pointerup", (event) => {
    if (start === null) return;
    const [low, high] = [start, place(event).x].sort((a, b) => a - b);
    start = null;
    brush.setAttribute("width", 0);
    if (8 > high - low) return;
    fill((low - shift) / scale, (high - shift) / scale);
  });
  svg.addEventListener("dblclick", whole);
  svg.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const zoom = { "+": 2, "-": 0.5 }[event.key];
    if (step) {
      const x = Math.min(right, Math.max(left, cursor + step * (right - left) / 100));
      read({ x, y: (top + bottom) / 2 });
    } else if (zoom) {
      const middle = (cursor - shift) / scale;
      const half = Math.min((right - left) / 2, (right - left) / (2 * scale * zoom));
      const from = Math.min(right - 2 * half, Math.max(left, middle - half));
      fill(from, from + 2 * half);
    } else if (event.key === "Escape") whole();
    else return;
    event.preventDefault();
  });
}
