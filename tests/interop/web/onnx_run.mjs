// Runs an ONNX model in onnxruntime-web (WebAssembly, one thread) inside Node.
//
//   node onnx_run.mjs MODEL.onnx PHOTOS.f32 '{"shape": [batch, 3, height, width], "rounds": 1}'
//
// PHOTOS.f32 holds raw float32. Prints one line of JSON: the outputs, and milliseconds of processor time to load
// and of each run.

import fs from "node:fs";
import * as ort from "onnxruntime-web";

const [model, photos, options] = process.argv.slice(2);
const { shape, rounds } = JSON.parse(options);
ort.env.wasm.numThreads = 1;
const bytes = fs.readFileSync(photos);
const data = new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
const now = () => Object.values(process.cpuUsage()).reduce((sum, microseconds) => sum + microseconds / 1000, 0);
const started = now();
const session = await ort.InferenceSession.create(new Uint8Array(fs.readFileSync(model)), {
  executionProviders: ["wasm"],
});
const load = now() - started;
const times = [];
let outputs;
for (let round = 0; round < rounds; round++) {
  const start = now();
  outputs = await session.run({ photo: new ort.Tensor("float32", data, shape) });
  times.push(now() - start);
}
const found = session.outputNames.map((name) => [
  name,
  { dims: outputs[name].dims, data: Array.from(outputs[name].data) },
]);
console.log(JSON.stringify({ version: ort.env.versions.web, load, times, outputs: Object.fromEntries(found) }));
