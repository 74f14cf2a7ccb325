/** Plays what moves. */

import { element } from './dom';
import { texts } from './texts';
import type { Source } from './source';

/** What a player shows next: a frame, or the number of one. */
type Feed = (frame: VideoFrame | number) => void;

export class Player {
  private source: Source | null = null;
  private index = 0;
  private began = 0;
  private paused = true;
  private timer = 0;

  private readonly video = element<HTMLVideoElement>('video');
  private readonly bar = element('player');
  private readonly button = element('play');
  private readonly time = element<HTMLInputElement>('time');
  private readonly clock = element('clock');
  private readonly mute = element('mute');

  /** `isFree` tells whether a frame of an animation can be rendered now: those that cannot are not shown. */
  constructor(
    private readonly feed: Feed,
    private readonly isFree: () => boolean,
  ) {
    this.button.onclick = () => this.toggle();
    this.mute.onclick = () => {
      this.video.muted = !this.video.muted;
      this.label();
    };
    this.time.oninput = () => this.seek(Number(this.time.value));
    this.video.addEventListener('seeked', () => this.take());
    this.video.addEventListener('loadeddata', () => this.take());
    this.video.addEventListener('play', () => this.label());
    this.video.addEventListener('pause', () => this.label());
    const next = (): void => {
      if (this.video.readyState >= 2 && !this.video.paused) this.take();
      this.video.requestVideoFrameCallback(next);
    };
    this.video.requestVideoFrameCallback(next);
  }

  get isPlaying(): boolean {
    return this.source?.kind === 'animation' ? !this.paused : !this.video.paused;
  }

  open(source: Source): void {
    this.stop();
    this.source = source;
    this.bar.hidden = source.kind === 'still' || source.kind === 'stream';
    this.mute.hidden = source.kind !== 'clip' || source.clip.sound === null;
    element('record').hidden = source.kind !== 'stream';
    const { video } = this;
    if (source.kind === 'clip' || source.kind === 'stream') {
      if (source.kind === 'clip') video.src = source.url;
      else video.srcObject = source.stream;
      video.loop = true;
      video.muted = source.kind === 'stream';
      this.time.max = String(source.kind === 'clip' ? source.clip.duration : 0);
      this.play();
    } else if (source.kind === 'animation') {
      this.time.max = String(this.duration);
      this.play();
    }
    this.label();
  }

  stop(): void {
    clearTimeout(this.timer);
    this.paused = true;
    this.video.pause();
    this.video.removeAttribute('src');
    this.video.srcObject = null;
    this.video.load();
    this.source = null;
    this.index = 0;
  }

  toggle(): void {
    if (this.isPlaying) this.pause();
    else this.play();
  }

  pause(): void {
    clearTimeout(this.timer);
    this.paused = true;
    this.video.pause();
    this.label();
  }

  /** A frame of now, for a thumbnail or to be saved. */
  now(): VideoFrame | null {
    const has = this.source?.kind === 'clip' || this.source?.kind === 'stream';
    return has && this.video.readyState >= 2 ? new VideoFrame(this.video) : null;
  }

  private play(): void {
    if (this.source?.kind === 'animation') {
      this.paused = false;
      this.began = performance.now() - this.startOf(this.index);
      this.tick();
    } else {
      // Sound may be forbidden until the page was clicked.
      this.video.play().catch(() => {
        this.video.muted = true;
        this.video.play().catch(() => this.label());
      });
    }
    this.label();
  }

  private seek(seconds: number): void {
    if (this.source?.kind === 'animation') {
      this.index = this.frameAt(seconds * 1000);
      this.began = performance.now() - seconds * 1000;
      this.feed(this.index);
      this.label();
    } else {
      this.video.currentTime = seconds;
    }
  }

  private get delays(): number[] {
    return this.source?.kind === 'animation' ? this.source.animation.delays : [];
  }

  private get duration(): number {
    return this.delays.reduce((sum, delay) => sum + delay, 0) / 1000;
  }

  private startOf(index: number): number {
    return this.delays.slice(0, index).reduce((sum, delay) => sum + delay, 0);
  }

  private frameAt(milliseconds: number): number {
    let end = 0;
    const found = this.delays.findIndex(delay => (end += delay) > milliseconds);
    return found < 0 ? this.delays.length - 1 : found;
  }

  private tick(): void {
    if (this.paused || this.source?.kind !== 'animation') return;
    const whole = 1000 * this.duration;
    const at = (performance.now() - this.began) % whole;
    if (this.isFree()) {
      this.index = this.frameAt(at);
      this.feed(this.index);
    }
    this.label();
    const end = this.startOf(this.index) + (this.delays[this.index] ?? 100);
    const wait = Math.max(4, this.isFree() ? end - at : 8);
    this.timer = window.setTimeout(() => this.tick(), wait);
  }

  private take(): void {
    const { video } = this;
    if (!this.source || video.readyState < 2) return;
    this.label();
    this.feed(new VideoFrame(video));
  }

  private label(): void {
    const { isPlaying, video } = this;
    this.button.setAttribute('aria-label', isPlaying ? texts.play.pause : texts.play.play);
    this.button.dataset.state = isPlaying ? 'playing' : 'paused';
    this.mute.setAttribute('aria-label', video.muted ? texts.play.unmute : texts.play.mute);
    this.mute.dataset.state = video.muted ? 'muted' : 'loud';
    const isClip = this.source?.kind === 'clip';
    const now = isClip ? video.currentTime : this.startOf(this.index) / 1000;
    const whole = isClip && this.source?.kind === 'clip' ? this.source.clip.duration : this.duration;
    if (document.activeElement !== this.time || isPlaying) this.time.value = String(now);
    this.time.style.setProperty('--share', `${whole > 0 ? (100 * now) / whole : 0}%`);
    this.clock.textContent = `${minutes(now)} / ${minutes(whole)}`;
  }
}

function minutes(seconds: number): string {
  const whole = Math.floor(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, '0')}`;
}
