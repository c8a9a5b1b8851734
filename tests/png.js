// Reads the drivers' pictures.
"use strict";

const fs = require("fs");
const zlib = require("zlib");

// The RGB bytes of a PNG of 8 bits per channel without interlacing, as the drivers write it.
function decode(file) {
  const png = fs.readFileSync(file), data = [];
  let width = 0, height = 0;
  for (let at = 8; at < png.length; at += 12 + png.readUInt32BE(at)) {
    const kind = png.toString("latin1", at + 4, at + 8), size = png.readUInt32BE(at);
    if (kind === "IHDR") [width, height] = [png.readUInt32BE(at + 8), png.readUInt32BE(at + 12)];
    if (kind === "IDAT") data.push(png.subarray(at + 8, at + 8 + size));
  }
  const rows = zlib.inflateSync(Buffer.concat(data)), stride = 3 * width, out = Buffer.alloc(stride * height);
  for (let y = 0; y < height; y++) {
    const filter = rows[y * (stride + 1)];
    for (let x = 0; x < stride; x++) {
      const left = x >= 3 ? out[y * stride + x - 3] : 0, up = y ? out[(y - 1) * stride + x] : 0;
      const corner = x >= 3 && y ? out[(y - 1) * stride + x - 3] : 0;
      const guess = left + up - corner, near = [left, up, corner].map((value) => Math.abs(guess - value));
      const paeth = near[0] <= near[1] && near[0] <= near[2] ? left : near[1] <= near[2] ? up : corner;
      out[y * stride + x] = rows[y * (stride + 1) + 1 + x] + [0, left, up, (left + up) >> 1, paeth][filter];
    }
  }
  return {width, height, rgb: out};
}

module.exports = {decode};
