/** What is shown: a picture, an animation, a clip, or what a camera sees. */

import type { EngineWorker } from './engine';
import { texts } from './texts';
import type { Animation, Clip } from './messages';

interface Common {
  name: string;
  width: number;
  height: number;
}
export type Source = Common &
  (
    | { kind: 'still'; picture: ImageBitmap }
    | { kind: 'animation'; file: Blob; type: string; animation: Animation }
    | { kind: 'clip'; file: Blob; clip: Clip; url: string }
    | { kind: 'stream'; stream: MediaStream }
  );

/** Another picture with the same pixels: colours that are not opaque stay as they are. */
export function copyOf(picture: ImageBitmap): Promise<ImageBitmap> {
  return createImageBitmap(picture, { premultiplyAlpha: 'none' });
}

/** Kinds of pictures by what their files begin with. */
const SIGNS: [string, RegExp][] = [
  ['image/gif', /^GIF8/],
  ['image/png', /^\x89PNG/],
  ['image/jpeg', /^\xff\xd8\xff/],
  ['image/webp', /^RIFF[^]{4}WEBP/],
  ['image/avif', /^[^]{4}ftyp(avif|avis)/],
  ['image/bmp', /^BM/],
  ['image/svg+xml', /^\s*(<\?xml[^]*)?<svg/],
];

async function kindOf(file: Blob): Promise<string> {
  const bytes = new Uint8Array(await file.slice(0, 512).arrayBuffer());
  const begin = String.fromCharCode(...bytes);
  return SIGNS.find(([, sign]) => sign.test(begin))?.[0] ?? file.type;
}

/** Opens a file of any kind. */
export async function openFile(file: File, worker: EngineWorker): Promise<Source> {
  if (file.size === 0) throw new Error(texts.errors.empty);
  const type = await kindOf(file);
  const name = file.name || 'picture';
  if (type.startsWith('image/')) return openPicture(file, type, name, worker);
  const clip = await worker.ask('openClip', file);
  if (!clip.decodable) throw new Error(texts.errors.codec(clip.codec ?? '?'));
  const { width, height } = clip;
  return { kind: 'clip', name, width, height, file, clip, url: URL.createObjectURL(file) };
}

async function openPicture(file: File, type: string, name: string, worker: EngineWorker): Promise<Source> {
  // Jpegs and bitmaps never move, and one of them may be large.
  const may = ['image/gif', 'image/png', 'image/webp', 'image/avif'].includes(type);
  const animation = may ? await worker.ask('openAnimation', { file, type }).catch(() => null) : null;
  if (animation) {
    const { width, height } = animation;
    return { kind: 'animation', name, width, height, file, type, animation };
  }
  const picture = await createImageBitmap(file, {
    premultiplyAlpha: 'none',
    imageOrientation: 'from-image',
  }).catch(() => {
    throw new Error(texts.errors.unreadable);
  });
  return { kind: 'still', name, width: picture.width, height: picture.height, picture };
}

/** What a camera or a screen shows. */
export async function openStream(stream: MediaStream, name: string): Promise<Source> {
  const { width = 1280, height = 720 } = stream.getVideoTracks()[0]?.getSettings() ?? {};
  return { kind: 'stream', name, width, height, stream };
}

/** Gives back what a source holds. */
export function closeSource(source: Source | null): void {
  if (source?.kind === 'still') source.picture.close();
  if (source?.kind === 'clip') URL.revokeObjectURL(source.url);
  if (source?.kind === 'stream') for (const track of source.stream.getTracks()) track.stop();
}
