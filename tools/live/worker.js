// A live figure's worker: runs the driver that the page asks for, with the module that it was sent first.
let module = null;
const kept = {};
onmessage = ({data}) => {
  module = data.module || module;
  if (!data.args) return;
  const started = performance.now();
  let result;
  try {
    result = runDriver(module, data.args, (part) => data.tells && postMessage({...part, id: data.id, part: true}), kept, data.part);
  } catch (error) { // a trap: out of memory, or of stack
    result = {status: 3, printed: "", rows: [], said: `the driver ended: ${error.message}`, picture: null, mean: null, finish: null};
  }
  postMessage({...result, id: data.id, ms: performance.now() - started});
};
