/** Has frames rendered for the screen, the newest first. */

import { element } from './dom';
import type { EngineWorker } from './engine';
import type { State } from './settings';
import { copyOf, type Source } from './source';
import type { Rendered } from './messages';

/** The longest side of a picture while a control is dragged, of one that rests, and of one that moves. */
const DRAFT = 640;
const REST = window.innerWidth < 700 ? 1000 : 1600;
const MOVING = 1280;
/** Milliseconds without a change after which a picture is drawn in full. */
const CALM = 160;
/** Milliseconds of rendering up to which a second frame is sent before the first is back: the worker need not wait then. */
const QUICK = 60;

export class Show {
  private source: Source | null = null;
  private state: State = { settings: {}, mask: null };
  /** Pictures that the worker has not sent yet. */
  private underWay = 0;
  private milliseconds = 0;
  private wanted: 'nothing' | 'draft' | 'full' = 'nothing';
  private next: VideoFrame | ImageBitmap | number | null = null;
  private isMoving = false;
  private calm = 0;
  private pictures = 0;
  private times: number[] = [];
  private readonly stage = element('stage');
  private readonly canvas = element<HTMLCanvasElement>('picture');
  private readonly before = element<HTMLCanvasElement>('before');

  constructor(
    private readonly worker: EngineWorker,
    private readonly shown: (rendered: Rendered) => void,
    private readonly failed: (error: unknown) => void,
  ) {}

  get isFree(): boolean {
    return !this.isBusy && this.next === null;
  }

  private get isBusy(): boolean {
    return this.underWay >= (this.isMoving && this.milliseconds < QUICK ? 2 : 1);
  }

  /** Frames a second over the last second. */
  get rate(): number {
    const now = performance.now();
    this.times = this.times.filter(time => now - time < 1000);
    return this.times.length;
  }

  async open(source: Source, state: State): Promise<void> {
    this.source = source;
    this.state = state;
    this.isMoving = false;
    this.dropNext();
    this.stage.style.setProperty('--ratio', String(source.width / source.height));
    if (source.kind !== 'still') return;
    show(this.before, await copyOf(source.picture));
    this.next = await copyOf(source.picture);
    this.wanted = 'draft';
    this.later();
    void this.pump();
  }

  /** The look has changed. */
  tune(state: State, dragging: boolean): void {
    this.state = state;
    if (!this.source) return;
    // The next frame of what plays shows it anyway.
    this.wanted = dragging || this.source.kind === 'still' ? 'draft' : 'full';
    this.later();
    void this.pump();
  }

  /** Another frame is to be shown. */
  feed(frame: VideoFrame | number, isPlaying: boolean): void {
    this.dropNext();
    this.next = frame;
    this.isMoving = isPlaying;
    void this.pump();
  }

  private dropNext(): void {
    if (this.next !== null && typeof this.next !== 'number') this.next.close();
    this.next = null;
  }

  /** Draws in full what was drawn as a draft, once nothing changes. */
  private later(): void {
    clearTimeout(this.calm);
    this.calm = window.setTimeout(() => {
      if (this.wanted === 'draft' && this.isBusy) return this.later();
      if (this.source?.kind !== 'still') return;
      this.wanted = 'full';
      void this.pump();
    }, CALM);
  }

  private async pump(): Promise<void> {
    const { source, next: frame, wanted } = this;
    if (this.isBusy || !source || (frame === null && wanted === 'nothing')) return;
    this.underWay++;
    this.next = null;
    this.wanted = 'nothing';
    const still = source.kind === 'still';
    const isDraft = still && wanted !== 'full';
    const most = still ? (isDraft ? DRAFT : REST) : MOVING;
    const { settings, mask } = this.state;
    const { width, height } = source;
    const goesOn = !still && frame !== null && this.isMoving;
    const transfer = frame !== null && typeof frame !== 'number' ? [frame] : [];
    try {
      const job = { settings, mask, width, height, most, goesOn, isDraft, frame };
      const rendered = await this.worker.ask('render', job, transfer);
      if (source === this.source) {
        show(this.canvas, rendered.picture);
        if (rendered.source) show(this.before, rendered.source);
        this.stage.dataset.shown = source.name;
      }
      this.milliseconds = rendered.milliseconds;
      this.times.push(performance.now());
      this.stage.dataset.pictures = String(++this.pictures);
      this.stage.dataset.milliseconds = rendered.milliseconds.toFixed(1);
      this.stage.dataset.size = `${rendered.width}x${rendered.height}`;
      this.shown(rendered);
    } catch (error) {
      this.failed(error);
    } finally {
      this.underWay--;
    }
    void this.pump();
  }
}

/** Puts a picture on a canvas. */
export function show(canvas: HTMLCanvasElement, picture: ImageBitmap): void {
  if (canvas.width !== picture.width || canvas.height !== picture.height) {
    canvas.width = picture.width;
    canvas.height = picture.height;
  }
  canvas.getContext('bitmaprenderer')?.transferFromImageBitmap(picture);
}
