/** Keeps what a camera sees as a clip, which can be exported frame by frame then. */

import { element } from './dom';
import { texts } from './texts';

export class Recorder {
  private recorder: MediaRecorder | null = null;
  private readonly button = element('record');

  constructor(
    private readonly stream: () => MediaStream | null,
    private readonly recorded: (file: File) => void,
  ) {
    this.button.onclick = () => (this.recorder ? this.recorder.stop() : this.start());
    this.label();
  }

  private start(): void {
    const stream = this.stream();
    if (!stream) return;
    const parts: Blob[] = [];
    const recorder = new MediaRecorder(stream, { videoBitsPerSecond: 8e6 });
    recorder.ondataavailable = ({ data }) => parts.push(data);
    recorder.onstop = () => {
      this.recorder = null;
      this.label();
      const type = recorder.mimeType.split(';')[0] ?? 'video/webm';
      this.recorded(new File(parts, `recording.${type.endsWith('mp4') ? 'mp4' : 'webm'}`, { type }));
    };
    recorder.start(1000);
    this.recorder = recorder;
    this.label();
  }

  private label(): void {
    this.button.textContent = this.recorder ? texts.record.stop : texts.record.start;
    this.button.setAttribute('aria-pressed', String(this.recorder !== null));
  }
}
