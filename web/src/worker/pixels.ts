/** Pixels of what the browser decodes: RGBA, sRGB, alpha not premultiplied. */

import type { VideoSample } from 'mediabunny';

export interface Pixels {
  width: number;
  height: number;
  rgba: Uint8Array;
}

let canvas: OffscreenCanvas | undefined;

/** The size of `width` x `height` with sides of at most `most`; 0 leaves it. */
export function fitted(width: number, height: number, most: number): [number, number] {
  const share = most > 0 ? Math.min(1, most / Math.max(width, height)) : 1;
  return [Math.max(1, Math.round(width * share)), Math.max(1, Math.round(height * share))];
}

function drawn(
  width: number,
  height: number,
  draw: (context: OffscreenCanvasRenderingContext2D) => void,
): Pixels {
  canvas ??= new OffscreenCanvas(width, height);
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  const context = canvas.getContext('2d', { willReadFrequently: true, colorSpace: 'srgb' });
  if (!context) throw new Error('This browser has no canvas for a worker.');
  context.clearRect(0, 0, width, height);
  context.imageSmoothingQuality = 'high';
  draw(context);
  const { data } = context.getImageData(0, 0, width, height);
  return { width, height, rgba: new Uint8Array(data.buffer, data.byteOffset, data.byteLength) };
}

/** A canvas would round colours that are not opaque: frames copy their pixels as they are. */
async function copied(frame: VideoFrame): Promise<Pixels | null> {
  const { displayWidth: width, displayHeight: height, visibleRect } = frame;
  if (visibleRect?.width !== width || visibleRect.height !== height) return null;
  const rgba = new Uint8Array(4 * width * height);
  // A conversion would round colours that are not opaque, too.
  const isPlain = frame.format === 'RGBA' || frame.format === 'BGRA';
  try {
    await frame.copyTo(rgba, isPlain ? {} : { format: 'RGBA', colorSpace: 'srgb' });
  } catch {
    return null;
  }
  if (frame.format === 'BGRA') swapRedAndBlue(rgba);
  return { width, height, rgba };
}

function swapRedAndBlue(rgba: Uint8Array): void {
  const pixels = new Uint32Array(rgba.buffer);
  for (let i = 0; i < pixels.length; i++) {
    const pixel = pixels[i] ?? 0;
    pixels[i] = (pixel & 0xff00ff00) | ((pixel & 0xff) << 16) | ((pixel >>> 16) & 0xff);
  }
}

/** The pixels of a frame or picture, with sides of at most `most`. The frame is not closed. */
export async function pixelsOf(frame: VideoFrame | ImageBitmap, most: number): Promise<Pixels> {
  const isVideo = frame instanceof VideoFrame;
  const [wide, high] = isVideo ? [frame.displayWidth, frame.displayHeight] : [frame.width, frame.height];
  const [width, height] = fitted(wide, high, most);
  if (width === wide && height === high) {
    const whole = isVideo ? frame : new VideoFrame(frame, { timestamp: 0, alpha: 'keep' });
    try {
      const pixels = await copied(whole);
      if (pixels) return pixels;
    } finally {
      if (!isVideo) whole.close();
    }
  }
  return drawn(width, height, context => context.drawImage(frame, 0, 0, width, height));
}

/** The pixels of a clip's frame, turned as it is to be shown. */
export async function pixelsOfSample(sample: VideoSample, most: number): Promise<Pixels> {
  const { displayWidth, displayHeight, rotation, flip } = sample;
  const [width, height] = fitted(displayWidth, displayHeight, most);
  if (width === displayWidth && height === displayHeight && rotation === 0 && !flip) {
    const frame = sample.toVideoFrame();
    try {
      const pixels = await copied(frame);
      if (pixels) return pixels;
    } finally {
      frame.close();
    }
  }
  return drawn(width, height, context => sample.draw(context, 0, 0, width, height));
}

/** Pixels as a picture that a canvas shows. */
export function bitmapOf({ width, height, rgba }: Pixels): Promise<ImageBitmap> {
  const bytes = new Uint8ClampedArray(rgba.buffer as ArrayBuffer, rgba.byteOffset, rgba.byteLength);
  return createImageBitmap(new ImageData(bytes, width, height));
}
