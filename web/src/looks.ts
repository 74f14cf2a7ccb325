/** The presets, each on the picture that is open. */

import { element, make } from './dom';
import { EngineWorker } from './engine';
import type { Settings } from './messages';
import type { Store } from './settings';
import { show } from './show';
import type { Source } from './source';
import { texts } from './texts';

/** The longest side of a thumbnail. */
const LONGEST = 240;

interface Look {
  name: string | null;
  button: HTMLButtonElement;
  canvas: HTMLCanvasElement;
}

export class Looks {
  private worker: EngineWorker | null = null;
  private readonly looks: Look[];
  /** The preset that holds where none is named. */
  private readonly usual: string | null;
  private round = 0;

  constructor(private readonly store: Store) {
    // The look without a preset comes first. One of the presets may be just that.
    const { presets } = store.described;
    const usual = presets.find(({ options }) => Object.keys(options).length === 0);
    this.usual = usual?.name ?? null;
    const first = usual ?? { name: null, about: '' };
    this.looks = [first, ...presets.filter(preset => preset !== usual)].map(({ name, about }) => {
      const canvas = make('canvas', { 'aria-hidden': 'true' });
      const words = name === null ? (texts.looks.none ?? '') : nice(name);
      const button = make('button', { type: 'button', class: 'look', title: about }, canvas, make('span', {}, words));
      button.onclick = () => store.replace(name === null || name === this.usual ? {} : { preset: name });
      element('looks').append(button);
      return { name, button, canvas };
    });
    this.mark();
  }

  /** Shows which preset holds. */
  mark(): void {
    const { settings } = this.store.state;
    for (const { name, button } of this.looks) {
      button.setAttribute('aria-pressed', String((settings.preset ?? this.usual) === name));
    }
  }

  /** Draws all thumbnails from `frame`, which it closes. */
  async draw(source: Source, frame: VideoFrame | ImageBitmap): Promise<void> {
    const round = ++this.round;
    const share = Math.min(1, LONGEST / Math.max(source.width, source.height));
    const resized = {
      resizeWidth: Math.max(1, Math.round(source.width * share)),
      resizeHeight: Math.max(1, Math.round(source.height * share)),
      resizeQuality: 'high' as const,
    };
    const small = await createImageBitmap(frame, resized);
    frame.close();
    this.worker ??= new EngineWorker();
    for (const { name, canvas } of this.looks) {
      if (round !== this.round) break;
      const settings: Settings = name === null ? {} : { preset: name };
      const { width, height } = source;
      const job = { settings, mask: null, width, height, most: LONGEST, goesOn: false, isDraft: false };
      const copy = await createImageBitmap(small);
      const rendered = await this.worker.ask('thumbnail', { ...job, frame: copy }, [copy]);
      if (round === this.round) show(canvas, rendered.picture);
    }
    small.close();
  }
}

function nice(name: string): string {
  const words = name.replaceAll('-', ' ');
  return words.charAt(0).toUpperCase() + words.slice(1);
}
