// Pictures in few bytes.

import { deflateSync } from "node:zlib";

/** A picture of a part of the page, { x, y, width, height }, as a PNG. */
export async function picture(page, clip) {
  const shot = await page.screenshot({ clip });
  return encode(await pixels(page, shot), clip.width, clip.height);
}

/** The red, green and blue bytes of a picture, in steps of four, which no one sees and which make the file small. */
const pixels = (page, png) =>
  page.evaluate(async (data) => {
    const image = await createImageBitmap(new Blob([Uint8Array.from(atob(data), (c) => c.charCodeAt(0))]));
    const canvas = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height });
    const pen = canvas.getContext("2d");
    pen.drawImage(image, 0, 0);
    const { data: bytes } = pen.getImageData(0, 0, image.width, image.height);
    return Array.from(bytes.filter((_, k) => k % 4 < 3), (x) => Math.min(255, 4 * Math.round(x / 4)));
  }, png.toString("base64"));

/** A PNG with the best compression: a browser's own are made fast. */
function encode(bytes, width, height) {
  const chunk = (name, content) => {
    const named = Buffer.concat([Buffer.from(name), content]), length = Buffer.alloc(4), check = Buffer.alloc(4);
    length.writeUInt32BE(content.length);
    check.writeUInt32BE(crc32(named));
    return Buffer.concat([length, named, check]);
  };
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header.set([8, 2, 0, 0, 0], 8);
  const row = (y) => Buffer.from([0, ...bytes.slice(3 * width * y, 3 * width * (y + 1))]);
  const rows = deflateSync(Buffer.concat(Array.from({ length: height }, (_, y) => row(y))), { level: 9 });
  return Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), chunk("IHDR", header), chunk("IDAT", rows), chunk("IEND", Buffer.alloc(0))]);
}

/** The check sum of PNG, bit by bit. */
function crc32(bytes) {
  let sum = ~0;
  for (const byte of bytes) {
    sum ^= byte;
    for (let bit = 0; bit < 8; bit++) sum = sum & 1 ? (sum >>> 1) ^ 0xedb88320 : sum >>> 1;
  }
  return ~sum >>> 0;
}
