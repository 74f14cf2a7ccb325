/** Clips: MP4, MOV, WebM, Matroska and others, by mediabunny and WebCodecs. */

import { ALL_FORMATS, BlobSource, Input, type InputVideoTrack } from 'mediabunny';
import { texts } from '../texts';
import type { Clip } from '../messages';

export function openInput(file: Blob): Input {
  return new Input({ source: new BlobSource(file), formats: ALL_FORMATS });
}

/** The picture track of a clip. */
export async function videoOf(input: Input): Promise<InputVideoTrack> {
  const readable = await input.canRead().catch(() => false);
  const track = readable ? await input.getPrimaryVideoTrack().catch(() => null) : null;
  if (!track) throw new Error(readable ? texts.errors.noPicture : texts.errors.unreadable);
  return track;
}

export async function describeClip(file: Blob): Promise<Clip> {
  const input = openInput(file);
  try {
    const track = await videoOf(input);
    const sound = await input.getPrimaryAudioTrack();
    return {
      width: await track.getDisplayWidth(),
      height: await track.getDisplayHeight(),
      duration: (await input.getDurationFromMetadata()) ?? (await input.computeDuration()),
      codec: await track.getCodec(),
      decodable: await track.canDecode(),
      sound: sound ? await sound.getCodec() : null,
    };
  } finally {
    input.dispose();
  }
}
