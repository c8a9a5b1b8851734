// Shows a picture, the wanted one, and where they differ.

export const BLACK_AT = 64; // a difference of so many of 255 levels, and more, is shown black
const LEVELS = 8; // fewer have come of rounding: the wanted picture was drawn by another compiler

function put(canvas, pixels, width, height) {
  Object.assign(canvas, {width, height});
  canvas.getContext("2d").putImageData(new ImageData(pixels, width, height), 0, 0);
}

async function pixels_of(address, {width, height}) {
  const image = new Image();
  image.src = address;
  await image.decode();
  const canvas = Object.assign(document.createElement("canvas"), {width, height}), context = canvas.getContext("2d");
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, width, height).data;
}

// canvases: {own, wanted, difference}; picture: {pixels, width, height}, RGBA, as large as the wanted one. Returns the
// number of pixels that differ by more than rounding.
export async function compare(canvases, picture, address) {
  const {pixels, width, height} = picture, wanted = await pixels_of(address, picture);
  const difference = new Uint8ClampedArray(wanted.length);
  let differ = 0;
  for (let i = 0; i < wanted.length; i += 4) {
    const most = Math.max(...[0, 1, 2].map((channel) => Math.abs(pixels[i + channel] - wanted[i + channel])));
    difference.fill(255 - Math.min(255, most * 255 / BLACK_AT), i, i + 3);
    difference[i + 3] = 255;
    differ += most > LEVELS;
  }
  put(canvases.own, pixels, width, height);
  put(canvases.wanted, wanted, width, height);
  put(canvases.difference, difference, width, height);
  return differ;
}
