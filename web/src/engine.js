// Functions of the library, called in a worker that can be ended.

const MODULE = new URL('./planish_web_bg.wasm', import.meta.url);

/// The reason why a call has no result, if it was cancelled.
export class Cancelled extends Error {}

/// A worker with the library, and calls that wait for it.
export class Engine {
  /// `onProgress` is told the stage of the work and the fraction of it that is done.
  constructor(onProgress) {
    this.onProgress = onProgress;
    this.module = compiled();
    this.start();
  }

  start() {
    this.waiting = new Map();
    this.worker = new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
    this.worker.onmessage = ({ data }) => this.answer(data);
    // Not started again: what failed would fail for ever.
    this.worker.onerror = (event) => this.fail(new Error(event.message || 'this browser cannot start the worker of the page'));
  }

  answer({ id, result, error, fault, stage, fraction }) {
    if (id === undefined) {
      this.onProgress(stage, fraction);
      return;
    }
    const call = this.waiting.get(id);
    this.waiting.delete(id);
    if (fault !== undefined) {
      const during = stage ? ` while ${stage}` : '';
      call.reject(new Error(`planish stopped${during}, mostly because the memory of the browser is exhausted (${fault})`));
      // The library is in no known state.
      this.stop(new Cancelled());
    } else if (error !== undefined) {
      call.reject(new Error(error));
    } else {
      call.resolve(result);
    }
  }

  /// Calls a function of the library.
  async call(name, ...parameters) {
    const worker = this.worker;
    const module = await this.module;
    if (worker !== this.worker) throw new Cancelled();
    return new Promise((resolve, reject) => {
      const id = (this.count = (this.count ?? 0) + 1);
      this.waiting.set(id, { resolve, reject });
      const transfer = parameters.filter((value) => value instanceof Uint8Array).map((value) => value.buffer);
      worker.postMessage({ id, module, name, parameters }, transfer);
    });
  }

  /// Ends all work. What was in the memory of the worker is lost.
  cancel() {
    this.stop(new Cancelled());
  }

  stop(reason) {
    this.worker.terminate();
    const waiting = this.waiting;
    this.start();
    this.fail(reason, waiting);
  }

  fail(reason, waiting = this.waiting) {
    for (const call of waiting.values()) call.reject(reason);
  }
}

async function compiled() {
  const response = fetch(MODULE);
  try {
    return await WebAssembly.compileStreaming(response);
  } catch {
    // A host that does not say that the file is WebAssembly.
    return WebAssembly.compile(await (await fetch(MODULE)).arrayBuffer());
  }
}
