// Calls functions of the live page's modules for the Python tests: one JSON request per line on standard input, one JSON reply per line.
//   node page_modules.mjs FOLDER     FOLDER holds copies of the modules, and a package.json that says that they are modules
import { createInterface } from "node:readline";

// JSON has no NaN, and typed arrays as arrays.
const plain = (key, value) => (ArrayBuffer.isView(value) ? Array.from(value) : value);

for await (const line of createInterface({ input: process.stdin })) {
  const { module, body, values } = JSON.parse(line);
  const names = await import(`${process.argv[2]}/${module}`);
  const result = await new Function("m", ...Object.keys(values), body)(names, ...Object.values(values));
  process.stdout.write(`${JSON.stringify(result, plain)}\n`);
}
