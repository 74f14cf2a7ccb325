/** Animations that the browser decodes: GIF, APNG, WebP, AVIF. */

import type { Animation } from '../messages';

/** An open animation. */
export class Frames {
  private constructor(private readonly decoder: ImageDecoder) {}

  /** The animation in a file; nothing where it is a picture that does not move, or no picture. */
  static async open(file: Blob, type: string): Promise<Frames | null> {
    if (!('ImageDecoder' in self) || !(await ImageDecoder.isTypeSupported(type))) return null;
    const decoder = new ImageDecoder({ data: await file.arrayBuffer(), type });
    await decoder.tracks.ready;
    await decoder.completed;
    const moving = (decoder.tracks.selectedTrack?.frameCount ?? 0) > 1;
    if (!moving) decoder.close();
    return moving ? new Frames(decoder) : null;
  }

  get count(): number {
    return this.decoder.tracks.selectedTrack?.frameCount ?? 0;
  }

  /** How often it is shown, 0 for ever. */
  get plays(): number {
    const repeats = this.decoder.tracks.selectedTrack?.repetitionCount ?? Infinity;
    return Number.isFinite(repeats) ? repeats + 1 : 0;
  }

  /** A frame, to be closed by the caller. */
  async frame(index: number): Promise<VideoFrame> {
    return (await this.decoder.decode({ frameIndex: index })).image;
  }

  async describe(): Promise<Animation> {
    const delays: number[] = [];
    let [width, height] = [0, 0];
    for (let index = 0; index < this.count; index++) {
      const frame = await this.frame(index);
      delays.push((frame.duration ?? 100_000) / 1000 || 100);
      [width, height] = [frame.displayWidth, frame.displayHeight];
      frame.close();
    }
    return { width, height, delays, plays: this.plays };
  }

  close(): void {
    this.decoder.close();
  }
}
