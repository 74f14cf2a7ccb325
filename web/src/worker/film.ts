/** MP4 and WebM, by WebCodecs and mediabunny. */

import {
  AudioSampleSink,
  AudioSampleSource,
  BufferTarget,
  EncodedAudioPacketSource,
  EncodedPacketSink,
  type InputAudioTrack,
  Mp4OutputFormat,
  Output,
  QUALITY_HIGH,
  VideoSample,
  VideoSampleSource,
  WebMOutputFormat,
  getFirstEncodableAudioCodec,
} from 'mediabunny';
import { texts } from '../texts';
import { codecFor } from './codecs';
import type { Source, Timed } from './source';

/** Seconds from one key frame to the next. */
const KEY_FRAMES = 2;

/** A film being written. */
export class Film {
  private constructor(
    private readonly output: Output<Mp4OutputFormat | WebMOutputFormat, BufferTarget>,
    private readonly pictures: VideoSampleSource,
    private readonly stride: number,
    private readonly width: number,
    private readonly height: number,
    private readonly sound: Promise<void>,
    readonly remark: string,
  ) {}

  static async begin(
    format: 'mp4' | 'webm',
    source: Source,
    size: { width: number; height: number },
  ): Promise<Film> {
    // Codecs halve the resolution of colour: a last odd row or column is left out.
    const [width, height] = [Math.max(2, size.width & ~1), Math.max(2, size.height & ~1)];
    const codec = await codecFor(format, width, height);
    if (!codec) throw new Error(texts.errors.noEncoder(format));
    const container = format === 'mp4' ? new Mp4OutputFormat() : new WebMOutputFormat();
    const output = new Output({ format: container, target: new BufferTarget() });
    const pictures = new VideoSampleSource({
      codec,
      bitrate: QUALITY_HIGH,
      keyFrameInterval: KEY_FRAMES,
      latencyMode: 'quality',
    });
    output.addVideoTrack(pictures);
    const sound = source.sound && (await soundOf(source.sound, output, source.origin));
    await output.start();
    const remark = source.sound && !sound ? texts.errors.soundLeftOut : '';
    return new Film(output, pictures, size.width, width, height, sound ? sound() : Promise.resolve(), remark);
  }

  async add(picture: Uint8Array, { start, length }: Timed): Promise<void> {
    const { width, height } = this;
    const sample = new VideoSample(cropped(picture, this.stride, width, height), {
      format: 'RGBA',
      codedWidth: width,
      codedHeight: height,
      timestamp: start,
      duration: length,
    });
    await this.pictures.add(sample);
    sample.close();
  }

  async finish(): Promise<Blob> {
    this.pictures.close();
    await this.sound;
    await this.output.finalize();
    const { buffer } = this.output.target;
    if (!buffer) throw new Error(texts.errors.noFrames);
    return new Blob([buffer], { type: await this.output.getMimeType() });
  }
}

/** The upper left part of a picture. */
function cropped(picture: Uint8Array, from: number, width: number, height: number): Uint8Array {
  if (from === width) return picture.subarray(0, 4 * width * height);
  const out = new Uint8Array(4 * width * height);
  for (let y = 0; y < height; y++) {
    out.set(picture.subarray(4 * y * from, 4 * (y * from + width)), 4 * y * width);
  }
  return out;
}

/** Adds a track for the sound: its packets as they are where the file can hold them. Returns what feeds it. */
async function soundOf(
  track: InputAudioTrack,
  output: Output<Mp4OutputFormat | WebMOutputFormat, BufferTarget>,
  origin: number,
): Promise<(() => Promise<void>) | null> {
  const known = output.format.getSupportedAudioCodecs();
  const codec = await track.getCodec();
  if (codec && known.includes(codec)) {
    const packets = new EncodedAudioPacketSource(codec);
    output.addAudioTrack(packets);
    return async () => {
      const decoderConfig = (await track.getDecoderConfig()) ?? undefined;
      for await (const packet of new EncodedPacketSink(track).packets()) {
        const timestamp = packet.timestamp - origin;
        if (timestamp >= 0) await packets.add(packet.clone({ timestamp }), { decoderConfig });
      }
      packets.close();
    };
  }
  const encodable = await getFirstEncodableAudioCodec(known, {
    numberOfChannels: await track.getNumberOfChannels(),
    sampleRate: await track.getSampleRate(),
  });
  if (!encodable || !(await track.canDecode())) return null;
  const samples = new AudioSampleSource({ codec: encodable, bitrate: QUALITY_HIGH });
  output.addAudioTrack(samples);
  return async () => {
    for await (const sample of new AudioSampleSink(track).samples()) {
      sample.setTimestamp(Math.max(0, sample.timestamp - origin));
      await samples.add(sample);
      sample.close();
    }
    samples.close();
  };
}
