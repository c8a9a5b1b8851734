// Files of the site are packed by gzip, because many servers send them as they are.

const MAGIC = [0x1f, 0x8b];

// Returns a response with the unpacked bytes of one, while they come. A server may have told the browser to unpack them.
export async function unpacked(response) {
  const reader = response.body.getReader(), {value: first = new Uint8Array()} = await reader.read();
  const body = new ReadableStream({
    start(controller) { controller.enqueue(first); },
    async pull(controller) {
      const {done, value} = await reader.read();
      if (done) controller.close();
      else controller.enqueue(value);
    },
  });
  const isPacked = MAGIC.every((byte, i) => first[i] === byte);
  return new Response(isPacked ? body.pipeThrough(new DecompressionStream("gzip")) : body,
    {headers: {"Content-Type": "application/wasm"}});
}
