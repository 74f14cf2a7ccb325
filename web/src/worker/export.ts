/** Exports: frame by frame, none left out. */

import { Apng, Engine, Enlarger, Gif, MeshStream, type Look, pngFile, svgFile } from '../../pkg/polyreel_wasm';
import type { ExportJob } from '../messages';
import { texts } from '../texts';
import { lookOf } from './look';
import { pixelsOf } from './pixels';
import { framesOf, type Source, type Timed } from './source';
import { Film } from './film';

type Done = { file: Blob; frames: number; remark: string };

export async function exported(
  job: ExportJob,
  report: (progress: number, frame: number) => void,
): Promise<Done> {
  // As in the program: GIFs have hard edges, and after a still nothing comes.
  const still = job.format === 'png' || job.format === 'svg';
  const own = job.format === 'gif' ? { edges: 'hard' } : still ? { coherence: 0 } : {};
  const settings = { ...job.settings, ...own };
  const look = lookOf(settings, job.mask);
  try {
    if (still) return await stillFile(job, look);
    const source = await framesOf(job);
    try {
      return await moving(job, look, source, report);
    } finally {
      source.close();
    }
  } finally {
    look.free();
  }
}

/** The first frame, or the picture itself. */
async function stillFile(job: ExportJob, look: Look): Promise<Done> {
  const { source } = job;
  if (source.kind !== 'still') throw new Error(texts.errors.oneFrame);
  const { width, height, rgba } = await pixelsOf(source.frame, job.most);
  source.frame.close();
  let file: Blob;
  if (job.format === 'svg') {
    file = new Blob([svgFile(look, rgba, width, height, job.title)], { type: 'image/svg+xml' });
  } else {
    const engine = engineOf(job, look);
    const picture = engine.render(rgba, width, height);
    engine.free();
    const { times } = job;
    const bytes = pngFile(picture, times * width, times * height);
    file = new Blob([bytes as Uint8Array<ArrayBuffer>], { type: 'image/png' });
  }
  return { file, frames: 1, remark: '' };
}

function engineOf({ times }: ExportJob, look: Look): Engine | Enlarger {
  return times > 1 ? new Enlarger(look, times) : new Engine(look);
}

/** What takes one frame after another. */
interface Sink {
  add(frame: Timed): Promise<void> | void;
  finish(): Promise<Blob> | Blob;
  remark?: string;
}

async function moving(
  job: ExportJob,
  look: Look,
  source: Source,
  report: (progress: number, frame: number) => void,
): Promise<Done> {
  const sink = await sinkOf(job, look, source);
  let frames = 0;
  for await (const frame of source.frames()) {
    await sink.add(frame);
    frames++;
    report(source.duration > 0 ? Math.min(1, (frame.start + frame.length) / source.duration) : 0, frames);
  }
  if (frames === 0) throw new Error(texts.errors.noFrames);
  return { file: await sink.finish(), frames, remark: sink.remark ?? '' };
}

async function sinkOf(job: ExportJob, look: Look, source: Source): Promise<Sink> {
  const { width, height, plays, alpha } = source;
  if (job.format === 'polyreel') {
    const stream = new MeshStream(look, width, height, plays, alpha);
    return {
      add: ({ rgba, start, length }) => stream.push(rgba, width, height, start * 1e6, length * 1e6),
      finish: () => blob(stream.finish(), 'application/octet-stream'),
    };
  }
  const engine = engineOf(job, look);
  const size = { width: job.times * width, height: job.times * height };
  if (job.format === 'mp4' || job.format === 'webm') {
    const film = await Film.begin(job.format, source, size);
    return {
      add: frame => film.add(engine.render(frame.rgba, width, height), frame),
      finish: () => film.finish(),
      remark: film.remark,
    };
  }
  const animation = job.format === 'gif' ? new Gif(size.width, size.height, plays, alpha) : new Apng(size.width, size.height, plays);
  const type = job.format === 'gif' ? 'image/gif' : 'image/png';
  const units = job.format === 'gif' ? 100 : 1000;
  const most = job.format === 'gif' ? 50 : 1000;
  // Delays are whole units: what is rounded off is made up for by the next one. Viewers show no more than `most` frames
  // a second; of more, some are left out.
  let written = 0;
  let waiting: Uint8Array | undefined;
  const flush = (end: number): void => {
    if (!waiting) return;
    const delay = Math.round(end * units) - written;
    if (delay < units / most) return;
    animation.push(waiting, Math.min(delay, 65535));
    written += delay;
    waiting = undefined;
  };
  let end = 0;
  return {
    add: frame => {
      flush(frame.start);
      waiting = engine.render(frame.rgba, width, height);
      end = frame.start + frame.length;
    },
    finish: () => {
      flush(Math.max(end, (written + units / most) / units));
      return blob(animation.finish(), type);
    },
  };
}

function blob(bytes: Uint8Array, type: string): Blob {
  return new Blob([bytes as Uint8Array<ArrayBuffer>], { type });
}
