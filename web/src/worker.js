// Runs planish beside the page, which stays alive meanwhile. A message names a function of the library and its arguments; the
// answer has its result, or the line that the command line would print.
import init, * as planish from './planish_web.js';

// Milliseconds between two messages of progress.
const INTERVAL = 50;

let stage = '';
let last = 0;
globalThis.planishProgress = (name, fraction) => {
  const now = performance.now();
  if (name === '' && now - last < INTERVAL) return;
  stage = name || stage;
  last = now;
  postMessage({ stage, fraction });
};

let ready;
onmessage = async ({ data: { id, module, name, parameters } }) => {
  ready ??= init({ module_or_path: module });
  try {
    await ready;
    const result = planish[name](...parameters);
    postMessage({ id, result }, result instanceof Uint8Array || result instanceof Float32Array ? [result.buffer] : []);
  } catch (error) {
    // Text is the library's own; all else is a fault, or memory that is exhausted.
    postMessage(typeof error === 'string' ? { id, error } : { id, fault: String(error), stage });
  }
};
