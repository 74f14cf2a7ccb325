/** All frames of a clip or an animation, one after another. */

import { VideoSampleSink, type InputAudioTrack } from 'mediabunny';
import type { ExportJob } from '../messages';
import { texts } from '../texts';
import { Frames } from './animation';
import { openInput, videoOf } from './clip';
import { fitted, pixelsOf, pixelsOfSample } from './pixels';

/** A frame with its time, in seconds. */
export interface Timed {
  rgba: Uint8Array;
  start: number;
  length: number;
}

export interface Source {
  width: number;
  height: number;
  /** Seconds. */
  duration: number;
  /** How often it is shown, 0 for ever. */
  plays: number;
  alpha: boolean;
  sound: InputAudioTrack | null;
  /** When the first frame is shown in the file's own time. */
  origin: number;
  frames(): AsyncGenerator<Timed>;
  close(): void;
}

export function framesOf(job: ExportJob): Promise<Source> {
  const { source } = job;
  if (source.kind === 'clip') return ofClip(source.file, job.most);
  if (source.kind === 'animation') return ofAnimation(source.file, source.type, job.most);
  throw new Error(texts.errors.onePicture);
}

async function ofClip(file: Blob, most: number): Promise<Source> {
  const input = openInput(file);
  const track = await videoOf(input);
  if (!(await track.canDecode())) {
    throw new Error(texts.errors.codec((await track.getCodec()) ?? '?'));
  }
  const [width, height] = fitted(await track.getDisplayWidth(), await track.getDisplayHeight(), most);
  const sink = new VideoSampleSink(track);
  const origin = Math.max(0, await track.getFirstTimestamp());
  return {
    width,
    height,
    duration: (await track.computeDuration()) - origin,
    plays: 0,
    alpha: false,
    sound: await input.getPrimaryAudioTrack(),
    origin,
    async *frames() {
      for await (const sample of sink.samples()) {
        const start = sample.timestamp - origin;
        const length = sample.duration;
        // A clip may begin before its own beginning.
        if (start + length <= 0 && length > 0) {
          sample.close();
          continue;
        }
        const { rgba } = await pixelsOfSample(sample, most);
        sample.close();
        yield { rgba, start: Math.max(0, start), length };
      }
    },
    close: () => input.dispose(),
  };
}

async function ofAnimation(file: Blob, type: string, most: number): Promise<Source> {
  const frames = await Frames.open(file, type);
  if (!frames) throw new Error(texts.errors.unreadable);
  const { width: wide, height: high, delays } = await frames.describe();
  const [width, height] = fitted(wide, high, most);
  const first = await frames.frame(0);
  const alpha = await hasAlpha(first, most);
  first.close();
  return {
    width,
    height,
    duration: delays.reduce((sum, delay) => sum + delay, 0) / 1000,
    plays: frames.plays,
    alpha,
    sound: null,
    origin: 0,
    async *frames() {
      let start = 0;
      for (const [index, delay] of delays.entries()) {
        const frame = await frames.frame(index);
        const { rgba } = await pixelsOf(frame, most);
        frame.close();
        yield { rgba, start: start / 1000, length: delay / 1000 };
        start += delay;
      }
    },
    close: () => frames.close(),
  };
}

async function hasAlpha(frame: VideoFrame, most: number): Promise<boolean> {
  const { rgba } = await pixelsOf(frame, most);
  for (let i = 3; i < rgba.length; i += 4) if (rgba[i] !== 255) return true;
  return false;
}
