// Grey PNG images of raw pixels: 8 bits, or 16 bits with the camera's own grey levels, which a canvas cannot save.

const SIGNATURE = [0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a];
const CRC_TABLE = Uint32Array.from({ length: 256 }, (_, n) => {
  let c = n;
  for (let k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c;
});

function crc32(bytes) {
  let c = 0xffffffff;
  for (const byte of bytes) c = CRC_TABLE[(c ^ byte) & 255] ^ (c >>> 8);
  return (c ^ 0xffffffff) >>> 0;
}

function chunk(name, data) {
  const bytes = new Uint8Array(12 + data.length);
  const view = new DataView(bytes.buffer);
  view.setUint32(0, data.length);
  bytes.set(new TextEncoder().encode(name), 4);
  bytes.set(data, 8);
  view.setUint32(8 + data.length, crc32(bytes.subarray(4, 8 + data.length)));
  return bytes;
}

/** Rows of big-endian samples, each after the number of its filter, 0 for none. */
function scanlines(values, width, height) {
  const wide = values instanceof Uint16Array;
  const rowBytes = 1 + width * (wide ? 2 : 1);
  const bytes = new Uint8Array(rowBytes * height);
  for (let y = 0; y < height; ++y) {
    const row = values.subarray(y * width, (y + 1) * width);
    if (!wide) bytes.set(row, y * rowBytes + 1);
    else {
      row.forEach((value, x) => {
        bytes[y * rowBytes + 1 + 2 * x] = value >> 8;
        bytes[y * rowBytes + 2 + 2 * x] = value & 255;
      });
    }
  }
  return { bytes, depth: wide ? 16 : 8 };
}

/** A PNG blob of grey levels. `values`: Uint8Array or Uint16Array, row by row. */
export async function greyPng({ values, width, height }) {
  const { bytes, depth } = scanlines(values, width, height);
  const header = new Uint8Array(13);
  const view = new DataView(header.buffer);
  view.setUint32(0, width);
  view.setUint32(4, height);
  header[8] = depth;
  const deflated = new Blob([bytes]).stream().pipeThrough(new CompressionStream("deflate"));
  const data = new Uint8Array(await new Response(deflated).arrayBuffer());
  return new Blob([new Uint8Array(SIGNATURE), chunk("IHDR", header), chunk("IDAT", data), chunk("IEND", new Uint8Array())], { type: "image/png" });
}
