/** The dialog that saves. */

import { download, element, make, readable, say, wordsOf } from './dom';
import { EngineWorker } from './engine';
import { maskFile } from './focus';
import type { ExportJob, Format } from './messages';
import type { State } from './settings';
import type { Source } from './source';
import { texts } from './texts';

const STILL: Format[] = ['png', 'svg'];
const MOVING: Format[] = ['mp4', 'webm', 'gif', 'apng', 'polyreel'];
const SIZES = [1920, 1280, 854, 640, 480];
/** How many times as large a picture may be drawn, and the longest side of one. */
const TIMES = [2, 3, 4, 8];
const LONGEST = 8192;
/** Formats that have no size of their own. */
const SIZELESS: Format[] = ['svg', 'polyreel'];
const ENDINGS: Record<Format, string> = {
  png: 'png', svg: 'svg', mp4: 'mp4', webm: 'webm', gif: 'gif', apng: 'png', polyreel: 'polyreel',
};

export class Save {
  private readonly dialog = element<HTMLDialogElement>('save');
  private readonly formats = element('formats');
  private readonly size = element<HTMLSelectElement>('size');
  private readonly go = element<HTMLButtonElement>('go');
  private readonly progress = element<HTMLProgressElement>('progress');
  private readonly outcome = element('outcome');
  private readonly line = element('line');
  private source: Source | null = null;
  private state: State = { settings: {}, mask: null };
  private running: EngineWorker | null = null;

  /** `frame` gives the frame that is seen. */
  constructor(
    private readonly worker: EngineWorker,
    private readonly frame: () => Promise<ImageBitmap | VideoFrame | null>,
  ) {
    this.go.onclick = () => void this.run();
    this.formats.onchange = () => void this.changed();
    this.size.onchange = () => void this.changed();
    element('cancel').onclick = () => (this.running ? this.running.end() : this.dialog.close());
    element('copy-line').onclick = () => {
      void navigator.clipboard.writeText(this.line.textContent ?? '').then(() => say(texts.status.lineCopied));
    };
    element('mask-file').onclick = async () => {
      if (this.state.mask) download(await maskFile(this.state.mask), 'focus.png');
    };
    this.dialog.addEventListener('close', () => this.running?.end());
  }

  async open(source: Source, state: State): Promise<void> {
    this.source = source;
    this.state = state;
    const moves = source.kind === 'animation' || source.kind === 'clip';
    const able = moves ? await this.worker.ask('codecs', source) : { mp4: null, webm: null };
    this.formats.querySelectorAll('.format').forEach(card => card.remove());
    for (const format of [...(moves ? MOVING : []), ...STILL]) {
      const missing = (format === 'mp4' || format === 'webm') && !able[format];
      this.formats.append(card(format, moves, missing));
    }
    const first = this.formats.querySelector<HTMLInputElement>('input:not(:disabled)');
    if (first) first.checked = true;
    this.size.replaceChildren(make('option', { value: '0' }, texts.sizes.own(source.width, source.height)));
    const longest = Math.max(source.width, source.height);
    for (const side of SIZES.filter(side => side < longest)) {
      const share = side / longest;
      const words = `${Math.round(source.width * share)} × ${Math.round(source.height * share)}`;
      this.size.append(make('option', { value: String(side) }, words));
    }
    for (const times of TIMES.filter(times => times * longest <= LONGEST)) {
      const words = texts.sizes.larger(times, times * source.width, times * source.height);
      this.size.append(make('option', { value: `x${times}` }, words));
    }
    this.outcome.textContent = '';
    this.progress.hidden = true;
    element('mask-note').hidden = state.mask === null;
    this.dialog.showModal();
    await this.changed();
  }

  private get format(): Format {
    return (this.formats.querySelector<HTMLInputElement>('input:checked')?.value ?? 'png') as Format;
  }

  /** The longest side of what is rendered, 0 for the source's own, and how many times as large it is drawn. */
  private get sizes(): { most: number; times: number } {
    const { value } = this.size;
    return value.startsWith('x') ? { most: 0, times: Number(value.slice(1)) } : { most: Number(value), times: 1 };
  }

  private get named(): string {
    const stem = (this.source?.name ?? 'picture').replace(/\.[^.]+$/, '');
    return `${stem}-lowpoly.${ENDINGS[this.format]}`;
  }

  /** The command line that does the same. */
  private async changed(): Promise<void> {
    const { source, format } = this;
    if (!source) return;
    for (const option of this.size.options) {
      option.disabled = option.value.startsWith('x') && SIZELESS.includes(format);
    }
    if (this.size.selectedOptions[0]?.disabled) this.size.value = '0';
    const { most, times } = this.sizes;
    const one = format === 'png' || format === 'svg';
    const more = [
      most > 0 ? `--max-size ${most}` : '',
      times > 1 ? `--scale ${times}` : '',
      one && (source.kind === 'clip' || source.kind === 'animation') ? '--frames 1' : '',
    ];
    this.line.textContent = '';
    const output = format === 'apng' ? this.named.replace(/png$/, 'apng') : this.named;
    this.line.textContent = await this.worker.ask('commandLine', {
      settings: this.state.settings,
      input: source.name,
      output,
      more: more.filter(Boolean).join(' '),
    });
  }

  private async job(source: Source): Promise<ExportJob | null> {
    const { format } = this;
    const { settings, mask } = this.state;
    const common = { settings, mask, format, ...this.sizes, title: source.name };
    if (format !== 'png' && format !== 'svg') {
      if (source.kind === 'clip') return { ...common, source: { kind: 'clip', file: source.file } };
      if (source.kind !== 'animation') return null;
      return { ...common, source: { kind: 'animation', file: source.file, type: source.type } };
    }
    const frame = await this.frame();
    return frame && { ...common, source: { kind: 'still', frame } };
  }

  private async run(): Promise<void> {
    const job = this.source && (await this.job(this.source));
    if (!job || this.running) return;
    const name = this.named;
    this.running = new EngineWorker();
    this.busy(true);
    try {
      const transfer = job.source.kind === 'still' ? [job.source.frame] : [];
      const began = performance.now();
      const { file, frames, remark } = await this.running.ask('export', job, transfer, (share, frame) => {
        this.progress.value = share;
        this.outcome.textContent = texts.status.frames(share, frame);
      });
      download(file, name);
      this.dialog.dataset.frames = String(frames);
      this.dialog.dataset.seconds = ((performance.now() - began) / 1000).toFixed(2);
      this.outcome.textContent = [texts.status.saved(name, readable(file.size)), remark].join(' ').trim();
    } catch (error) {
      const cancelled = error instanceof DOMException && error.name === 'AbortError';
      this.outcome.textContent = cancelled ? texts.status.cancelled : wordsOf(error);
    } finally {
      this.running?.end();
      this.running = null;
      this.busy(false);
    }
  }

  private busy(busy: boolean): void {
    this.go.disabled = busy;
    this.progress.hidden = !busy;
    this.progress.value = 0;
    this.dialog.dataset.state = busy ? 'busy' : 'idle';
    for (const input of this.formats.querySelectorAll('input')) input.toggleAttribute('data-busy', busy);
  }
}

function card(format: Format, moves: boolean, missing: boolean): HTMLElement {
  const [name, about] = texts.formats[format] ?? [format, ''];
  const words = missing ? texts.errors.noEncoder(format) : ((moves && texts.frame[format]) || about);
  const input = make('input', { type: 'radio', name: 'format', value: format, id: `format-${format}` });
  input.disabled = missing;
  const label = make('label', { for: input.id }, make('strong', {}, name), make('span', {}, words));
  return make('div', { class: 'format' }, input, label);
}
