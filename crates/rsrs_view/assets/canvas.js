"use strict";
// What pages draw swarms with: the colours of the theme, and square canvases as sharp as the screen.

function theme_colours(names) {
  const style = getComputedStyle(document.documentElement);
  return Object.fromEntries(
    names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}

function sharpen(canvas) {
  const side_px = Math.round(canvas.clientWidth * devicePixelRatio);
  if (side_px > 0 && side_px !== canvas.width) {
    canvas.width = side_px;
    canvas.height = side_px;
  }
}
