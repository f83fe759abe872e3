/** Where a point of a box is in the picture that is drawn in it, as large as fits, in its middle. Pure. */

interface Size {
  width: number;
  height: number;
}

/** Shares of the picture's width and height from its upper left; beyond 0…1 beside it. `x`, `y` from the box's. */
export function pictureShare(box: Size, picture: Size, x: number, y: number): { u: number; v: number } {
  const scale = Math.min(box.width / picture.width, box.height / picture.height);
  const [width, height] = [picture.width * scale, picture.height * scale];
  return { u: (x - (box.width - width) / 2) / width, v: (y - (box.height - height) / 2) / height };
}
