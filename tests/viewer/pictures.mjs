// Pictures and what they show: decoded by a browser, so that no library is needed.

export class Pictures {
  static async in(browser) {
    return new Pictures(await browser.newPage());
  }

  constructor(page) {
    this.page = page;
  }

  /**
   * Which pixels differ from the background: another picture, or the colour of the first pixel.
   * @param png  bytes
   */
  async silhouette(png, background = null) {
    const marks = await this.page.evaluate(
      async ([text, other]) => {
        const decode = async (base64) => {
          const image = new Image();
          image.src = `data:image/png;base64,${base64}`;
          await image.decode();
          const canvas = document.createElement('canvas');
          [canvas.width, canvas.height] = [image.width, image.height];
          const context = canvas.getContext('2d');
          context.drawImage(image, 0, 0);
          return context.getImageData(0, 0, image.width, image.height);
        };
        const picture = await decode(text);
        const behind = other ? (await decode(other)).data : null;
        const marks = [];
        for (let i = 0; i < picture.data.length; i += 4) {
          let difference = 0;
          for (let c = 0; c < 3; ++c)
            difference += Math.abs(picture.data[i + c] - (behind ? behind[i + c] : picture.data[c]));
          marks.push(difference > 8 ? 1 : 0);
        }
        return { width: picture.width, height: picture.height, marks };
      },
      [png.toString('base64'), background?.toString('base64')],
    );
    return marks;
  }
}

/** How much two silhouettes have in common, of what either has: 1 if they are the same. */
export function overlap(a, b) {
  if (a.width !== b.width || a.height !== b.height)
    throw new Error(`${a.width} x ${a.height} is not ${b.width} x ${b.height}`);
  let both = 0;
  let any = 0;
  a.marks.forEach((mark, i) => {
    both += mark & b.marks[i];
    any += mark | b.marks[i];
  });
  return both / any;
}

export function covered(silhouette) {
  return silhouette.marks.reduce((sum, mark) => sum + mark, 0) / silhouette.marks.length;
}
