/** What this browser can encode. */

import { QUALITY_HIGH, getFirstEncodableVideoCodec, type VideoCodec } from 'mediabunny';

/** Codecs by how well they are played elsewhere. VP8 comes before VP9: it is several times as fast. */
const ORDER: Record<'mp4' | 'webm', VideoCodec[]> = {
  mp4: ['avc', 'hevc', 'av1', 'vp9'],
  webm: ['vp8', 'vp9', 'av1'],
};

/** The codec for a file of this size; nothing where there is none. */
export function codecFor(
  format: 'mp4' | 'webm',
  width: number,
  height: number,
): Promise<VideoCodec | null> {
  return getFirstEncodableVideoCodec(ORDER[format], { width, height, bitrate: QUALITY_HIGH });
}

export async function codecs(
  width: number,
  height: number,
): Promise<{ mp4: string | null; webm: string | null }> {
  const [even, high] = [width & ~1, height & ~1];
  const [mp4, webm] = await Promise.all([codecFor('mp4', even, high), codecFor('webm', even, high)]);
  return { mp4, webm };
}
