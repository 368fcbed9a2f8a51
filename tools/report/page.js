// SPDX-License-Identifier: MIT
// Unpacks the plotting library, which the page carries, and draws its pictures one after the other, so that reading can begin at once.
"use strict";
const PAPER_WIDTH = 680; // pixels of A4 between page.css's margins
const BUTTONS = ["zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "autoScale2d", "resetScale2d", "toImage"];
const OPTIONS = {responsive: true, displaylogo: false, modeBarButtons: [BUTTONS]};
const figures = [...document.querySelectorAll("figure.chart")];

async function unpackLibrary() {
  const packed = Uint8Array.from(atob(document.getElementById("library").textContent), (c) => c.charCodeAt(0));
  const unpacked = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const script = document.createElement("script");
  script.textContent = await new Response(unpacked).text();
  document.head.append(script);
}

function draw(figure) {
  if (figure.dataset.drawn) return;
  const chart = JSON.parse(figure.querySelector("script").textContent);
  figure.querySelector(".waiting")?.remove();
  Plotly.newPlot(figure.querySelector(".plot"), chart.data, chart.layout, OPTIONS);
  figure.dataset.drawn = "yes";
}

function fit(width) {
  if (!window.Plotly) return;
  figures.forEach(draw);
  figures.forEach((figure) => Plotly.relayout(figure.querySelector(".plot"), width ? {width} : {width: null, autosize: true}));
}

window.addEventListener("beforeprint", () => fit(PAPER_WIDTH));
window.addEventListener("afterprint", () => fit(null));

(async () => {
  try {
    await unpackLibrary();
    for (const figure of figures) {
      draw(figure);
      await new Promise((resume) => setTimeout(resume));
    }
  } catch (error) {
    document.querySelectorAll(".waiting").forEach((place) => { place.textContent = "This browser cannot draw the picture: " + error.message; });
    throw error;
  } finally {
    document.documentElement.dataset.pictures = "done";
  }
})();
