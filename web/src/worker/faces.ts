/** Where faces are in a frame. */

import { findFaces } from '../../pkg/polyreel_wasm';
import type { Face } from '../messages';
import { pixelsOf } from './pixels';

/** The longest side of the picture in which they are looked for. */
const LONGEST = 640;

/** The faces in `frame`, which is closed. */
export async function facesIn(frame: ImageBitmap | VideoFrame): Promise<Face[]> {
  try {
    const { width, height, rgba } = await pixelsOf(frame, LONGEST);
    const numbers = findFaces(rgba, width, height);
    const faces: Face[] = [];
    for (let i = 0; i + 3 < numbers.length; i += 4) {
      const [left = 0, top = 0, wide = 0, high = 0] = numbers.subarray(i, i + 4);
      faces.push({ left: left / width, top: top / height, width: wide / width, height: high / height });
    }
    return faces;
  } finally {
    frame.close();
  }
}
