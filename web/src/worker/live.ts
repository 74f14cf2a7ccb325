/** Pictures for the screen. */

import { Engine } from '../../pkg/polyreel_wasm';
import type { RenderJob, Rendered } from '../messages';
import type { Frames } from './animation';
import { lookOf } from './look';
import { bitmapOf, fitted, pixelsOf, type Pixels } from './pixels';

/** Eighths of a step of refinement for frames that move, from much time to none; nothing is as the look says. */
const LADDER = [null, 12, 8, 5, 3, 2, 1, 0];
/** Shares of the time between two frames: above the first a frame comes too late, below the second there is time for more. */
const LATE = 0.85;
const EARLY = 0.5;
/** Milliseconds between frames that are counted on, where the clip has fewer or more: 30 and 24 a second. */
const SHORTEST = 1000 / 30;
const LONGEST = 1000 / 24;
/** Frames in a row that have to be late, or early. */
const LATE_FRAMES = 2;
const EARLY_FRAMES = 24;

/** The same of a still while a control is dragged. */
const DRAFT = 16;

/** Chooses how much refinement a frame that moves gets, so that it is there in time. Exports do not ask it. */
export class Pace {
  private rung = 0;
  private late = 0;
  private early = 0;
  private interval = LONGEST;
  private last = Number.NaN;

  get eighths(): number | null {
    return LADDER[this.rung] ?? null;
  }

  /** A frame of the clip's `time` in milliseconds took so many of them. */
  learn(milliseconds: number, time: number): void {
    const since = time - this.last;
    this.last = time;
    // Frames may have been left out in between: the least counts.
    if (since > 0) this.interval = Math.max(SHORTEST, Math.min(this.interval, since));
    this.late = milliseconds > LATE * this.interval ? this.late + 1 : 0;
    this.early = milliseconds < EARLY * this.interval ? this.early + 1 : 0;
    const worse = this.late >= LATE_FRAMES;
    if (!worse && this.early < EARLY_FRAMES) return;
    this.rung = Math.min(LADDER.length - 1, Math.max(0, this.rung + (worse ? 1 : -1)));
    this.late = 0;
    this.early = 0;
  }
}

/** Renders what is seen: each frame goes on from the last one, or begins afresh. */
export class Live {
  private engine: Engine | undefined;
  private readonly pace = new Pace();
  private tuned = '';
  private whole: VideoFrame | ImageBitmap | undefined;
  /** The frame's pixels by their longest side. */
  private readonly pixels = new Map<number, Pixels>();

  /** Renders a frame, which is closed when another one comes. */
  async render(job: RenderJob, animation: Frames | null): Promise<Rendered> {
    const asked = performance.now();
    const given = typeof job.frame === 'number' ? await animation?.frame(job.frame) : job.frame;
    if (given) {
      this.whole?.close();
      this.whole = given;
      this.pixels.clear();
    }
    if (!this.whole) throw new Error('There is no picture yet.');
    const pixels = this.pixels.get(job.most) ?? (await pixelsOf(this.whole, job.most));
    this.pixels.set(job.most, pixels);
    const { width, height, rgba } = pixels;
    const engine = this.ready(job, width, height);
    const began = performance.now();
    const eighths = job.goesOn ? this.pace.eighths : job.isDraft ? DRAFT : null;
    const out =
      eighths === null ? engine.render(rgba, width, height) : engine.renderBriefly(rgba, width, height, eighths);
    const milliseconds = performance.now() - began;
    const source = typeof job.frame === 'number' ? await bitmapOf(pixels) : undefined;
    const picture = await bitmapOf({ width, height, rgba: out });
    const { points, triangles } = engine;
    // A mesh that begins afresh counts, too: where frames are late, those left out between them make it do so.
    if (job.goesOn) this.pace.learn(performance.now() - asked, timeOf(this.whole));
    return { width, height, points, triangles, milliseconds, picture, source };
  }

  private ready(job: RenderJob, width: number, height: number): Engine {
    const tuned = JSON.stringify([job.settings, job.mask?.weights.length, width, height]) + maskStamp(job);
    if (this.engine && job.goesOn && tuned === this.tuned) return this.engine;
    const look = lookOf(job.settings, job.mask);
    const preview = look.forPreview(job.width, job.height, width, height);
    look.free();
    try {
      if (this.engine && job.goesOn) {
        this.engine.retune(preview);
      } else {
        this.engine?.free();
        this.engine = undefined;
        this.engine = new Engine(preview);
      }
    } finally {
      preview.free();
    }
    this.tuned = tuned;
    return this.engine;
  }
}

/** The time of a clip's frame in milliseconds. */
function timeOf(frame: VideoFrame | ImageBitmap): number {
  return frame instanceof VideoFrame ? frame.timestamp / 1000 : Number.NaN;
}

/** Something that is another number when the mask is another one. */
function maskStamp(job: RenderJob): string {
  let sum = 0;
  for (const weight of job.mask?.weights ?? []) sum = (sum * 31 + weight) | 0;
  return String(sum);
}

/** A small picture by another look. */
export async function thumbnail(job: RenderJob): Promise<Rendered> {
  const frame = job.frame;
  if (frame === null || typeof frame === 'number') throw new Error('There is no picture yet.');
  try {
    const pixels = await pixelsOf(frame, job.most);
    const [width, height] = fitted(job.width, job.height, job.most);
    const look = lookOf(job.settings, job.mask);
    const preview = look.forPreview(job.width, job.height, width, height);
    look.free();
    const engine = new Engine(preview);
    preview.free();
    try {
      const began = performance.now();
      const rgba = engine.render(pixels.rgba, pixels.width, pixels.height);
      const milliseconds = performance.now() - began;
      const picture = await bitmapOf({ ...pixels, rgba });
      const { points, triangles } = engine;
      return { width, height, points, triangles, milliseconds, picture };
    } finally {
      engine.free();
    }
  } finally {
    frame.close();
  }
}
