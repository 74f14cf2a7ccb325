/** The worker: everything that takes time. */

import init, { Look, described } from '../../pkg/polyreel_wasm';
import type { Job, Jobs, Request } from '../messages';
import { Frames } from './animation';
import { describeClip } from './clip';
import { codecs } from './codecs';
import { exported } from './export';
import { facesIn } from './faces';
import { Live, thumbnail } from './live';
import { lookOf } from './look';

const ready = init({ module_or_path: new URL('polyreel_wasm_bg.wasm', import.meta.url) });
const live = new Live();
let animation: Frames | null = null;

type Report = (progress: number, frame: number) => void;
type Doers = { [J in Job]: (job: Jobs[J]['job'], report: Report) => Promise<Jobs[J]['result']> };

const doers: Doers = {
  describe: async () => JSON.parse(described()),
  openClip: file => describeClip(file),
  openAnimation: async ({ file, type }) => {
    animation?.close();
    animation = await Frames.open(file, type);
    return animation && animation.describe();
  },
  render: job => live.render(job, animation),
  thumbnail: job => thumbnail(job),
  faces: frame => facesIn(frame),
  presetFile: async ({ settings, mask }) => {
    const look = lookOf(settings, mask);
    const text = look.toFile();
    look.free();
    return text;
  },
  readPresetFile: async text => {
    const look = Look.fromFile(text);
    const settings = JSON.parse(look.settings());
    look.free();
    return settings;
  },
  commandLine: async ({ settings, input, output, more }) => {
    const look = new Look(JSON.stringify(settings));
    const line = look.commandLine(input, output, more);
    look.free();
    return line;
  },
  codecs: ({ width, height }) => codecs(width, height),
  export: (job, report) => exported(job, report),
};

/** Pictures go over to the page, not a copy of them. */
function movable(result: unknown): Transferable[] {
  if (typeof result !== 'object' || result === null) return [];
  return Object.values(result).filter(value => value instanceof ImageBitmap);
}

async function perform(request: Request): Promise<void> {
  const { number, name, job } = request;
  try {
    await ready;
    const report: Report = (progress, frame) => postMessage({ number, progress, frame });
    const doer = doers[name] as (job: unknown, report: Report) => Promise<unknown>;
    const result = await doer(job, report);
    postMessage({ number, result }, { transfer: movable(result) });
  } catch (error) {
    postMessage({ number, error: error instanceof Error ? error.message : String(error) });
  }
}

// One after another: the engine keeps the last frame.
let line = Promise.resolve();
onmessage = ({ data }: MessageEvent<Request>) => {
  line = line.then(() => perform(data));
};
