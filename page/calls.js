"use strict";
// How a thread calls its instance of the simulator: numbers go in and out as they are, texts through one buffer.

let simulator;

// The address first: asking for it may grow the memory, which detaches an older buffer.
function put(text) {
  const bytes = new TextEncoder().encode(text);
  const at = simulator.text(bytes.length);
  new Uint8Array(simulator.memory.buffer, at, bytes.length).set(bytes);
}

function got(length) {
  const at = simulator.answer();
  const text = new TextDecoder().decode(new Uint8Array(simulator.memory.buffer, at, length));
  if (text.startsWith("!")) throw new Error(text.slice(1));
  return text;
}
