/** The page. */

import { Compare } from './compare';
import { Controls } from './controls';
import { download, element, say, wordsOf } from './dom';
import { EngineWorker } from './engine';
import { Painting } from './focus';
import { Looks } from './looks';
import { Player } from './player';
import { Recorder } from './record';
import { Save } from './save';
import { Store, type State } from './settings';
import { Show } from './show';
import { closeSource, copyOf, openFile, openStream, type Source } from './source';
import { texts } from './texts';

/** Everything that the page holds. */
class Page {
  private source: Source | null = null;
  private opening = 0;
  private readonly controls: Controls;
  private readonly looks: Looks;
  private readonly show: Show;
  private readonly player: Player;
  private readonly painting: Painting;
  private readonly compare = new Compare();
  private readonly save: Save;

  constructor(
    private readonly worker: EngineWorker,
    private readonly store: Store,
  ) {
    this.controls = new Controls(store);
    this.looks = new Looks(store);
    this.show = new Show(
      worker,
      ({ points, triangles }) => {
        this.controls.counted(points);
        element('facts').textContent = texts.status.facets(triangles.toLocaleString('en'));
        element('stage').dataset.rate = String(this.show.rate);
        document.body.dataset.state = 'shown';
      },
      error => say(wordsOf(error), true),
    );
    this.player = new Player(
      frame => {
        this.show.feed(frame, this.player.isPlaying);
        this.thumbnails();
      },
      () => this.show.isFree,
    );
    this.painting = new Painting(
      mask => this.store.paint(mask),
      async () => {
        const frame = await this.frame();
        return frame ? this.worker.ask('faces', frame, [frame]) : [];
      },
    );
    this.save = new Save(worker, () => this.frame());
    this.inputs();
    this.keys();
  }

  /** Shows the state of the controls, and has the picture drawn anew. */
  changed(state: State, dragging: boolean): void {
    if (!dragging) this.controls.show();
    element('lines').hidden = this.store.values.outline === null;
    this.looks.mark();
    this.show.tune(state, dragging);
    this.painting.show(state.mask);
    element<HTMLButtonElement>('undo').disabled = !this.store.canUndo;
    element<HTMLButtonElement>('redo').disabled = !this.store.canRedo;
    if (!dragging) history.replaceState(null, '', `#${this.store.toAddress()}`);
  }

  /** Opens what `make` gives, if nothing newer is being opened. */
  async open(make: () => Promise<Source>): Promise<void> {
    const round = ++this.opening;
    document.body.dataset.state = 'opening';
    element('facts').textContent = texts.status.opening;
    try {
      const source = await make();
      if (round !== this.opening) return closeSource(source);
      await this.take(source);
    } catch (error) {
      document.body.dataset.state = this.source ? 'shown' : 'empty';
      element('facts').textContent = '';
      say(wordsOf(error), true);
    }
  }

  private async take(source: Source): Promise<void> {
    this.player.stop();
    closeSource(this.source);
    this.source = source;
    this.drawn = false;
    const stage = element('stage');
    stage.dataset.kind = source.kind;
    this.controls.sized(source.width, source.height);
    // What the worker has not sent yet is not the last source's.
    Object.assign(element<HTMLCanvasElement>('before'), { width: 1, height: 1 });
    this.painting.open(source.width, source.height);
    if (this.store.state.mask) this.store.paint(null);
    this.compare.set(false);
    element('file').textContent = source.name;
    const moves = source.kind !== 'still';
    document.body.classList.toggle('moves', moves);
    element('coherence').closest<HTMLElement>('.slider')?.toggleAttribute('hidden', !moves);
    element<HTMLButtonElement>('open-save').disabled = false;
    await this.show.open(source, this.store.state);
    this.player.open(source);
    if (source.kind === 'still') this.thumbnails();
  }

  private drawn = false;

  /** Draws the thumbnails once, from the first frame that there is. */
  private thumbnails(): void {
    const { source } = this;
    if (this.drawn || !source) return;
    this.drawn = true;
    void this.frame()
      .then(frame => frame && this.looks.draw(source, frame))
      .catch(error => say(wordsOf(error), true));
  }

  /** The frame that is seen. */
  private async frame(): Promise<ImageBitmap | VideoFrame | null> {
    const { source } = this;
    if (source?.kind === 'still') return copyOf(source.picture);
    if (source?.kind === 'animation') {
      const before = element<HTMLCanvasElement>('before');
      // The worker sends the source with the picture: the first one may be on its way.
      return before.width > 1 ? createImageBitmap(before) : createImageBitmap(source.file);
    }
    return this.player.now();
  }

  openFiles(files: Iterable<File>): void {
    const [file] = files;
    if (!file) return;
    element('welcome').hidden = true;
    void this.open(() => openFile(file, this.worker));
  }

  /** Files, cameras, and the buttons of the header. */
  private inputs(): void {
    const picker = element<HTMLInputElement>('picker');
    picker.onchange = () => {
      this.openFiles(picker.files ?? []);
      picker.value = '';
    };
    for (const button of document.querySelectorAll<HTMLElement>('[data-open="file"]')) button.onclick = () => picker.click();
    for (const button of document.querySelectorAll<HTMLElement>('[data-open="camera"]')) {
      button.onclick = () => this.capture('camera');
    }
    for (const button of document.querySelectorAll<HTMLElement>('[data-open="screen"]')) {
      button.hidden = !('getDisplayMedia' in (navigator.mediaDevices ?? {}));
      button.onclick = () => this.capture('screen');
    }
    element('close-welcome').onclick = () => (element('welcome').hidden = true);
    window.addEventListener('dragover', event => {
      event.preventDefault();
      document.body.classList.add('over');
    });
    window.addEventListener('dragleave', event => {
      if (event.relatedTarget === null) document.body.classList.remove('over');
    });
    window.addEventListener('drop', event => {
      event.preventDefault();
      document.body.classList.remove('over');
      this.openFiles(event.dataTransfer?.files ?? []);
    });
    window.addEventListener('paste', event => this.openFiles(event.clipboardData?.files ?? []));
    element('undo').onclick = () => this.store.undo();
    element('redo').onclick = () => this.store.redo();
    element('open-save').onclick = () => {
      if (!this.source) return;
      if (this.source.kind !== 'still') this.player.pause();
      void this.save.open(this.source, this.store.state);
    };
    element('link').onclick = () => {
      void navigator.clipboard.writeText(location.href).then(() => say(texts.status.linkCopied));
    };
    this.presetFiles();
    new Recorder(
      () => (this.source?.kind === 'stream' ? this.source.stream : null),
      file => this.openFiles([file]),
    );
    window.addEventListener('hashchange', () => void this.look(location.hash));
  }

  private presetFiles(): void {
    element('save-preset').onclick = async () => {
      const { settings, mask } = this.store.state;
      try {
        const text = await this.worker.ask('presetFile', { settings, mask });
        download(new Blob([text], { type: 'application/toml' }), 'look.toml');
      } catch (error) {
        say(wordsOf(error), true);
      }
    };
    const picker = element<HTMLInputElement>('preset-picker');
    element('load-preset').onclick = () => picker.click();
    picker.onchange = async () => {
      const file = picker.files?.[0];
      picker.value = '';
      if (!file) return;
      try {
        this.store.replace(await this.worker.ask('readPresetFile', await file.text()));
        say(texts.status.presetLoaded(file.name));
      } catch (error) {
        say(texts.errors.preset(wordsOf(error)), true);
      }
    };
  }

  /** The look of an address; one that makes no sense is left out. */
  async look(hash: string): Promise<void> {
    if (hash.replace(/^#/, '') === this.store.toAddress()) return;
    try {
      const settings = this.store.fromAddress(hash);
      await this.worker.ask('presetFile', { settings, mask: null });
      this.store.replace(settings);
    } catch (error) {
      say(texts.errors.address(wordsOf(error)), true);
      history.replaceState(null, '', `#${this.store.toAddress()}`);
    }
  }

  private async capture(kind: 'camera' | 'screen'): Promise<void> {
    const { mediaDevices } = navigator;
    try {
      const stream =
        kind === 'camera'
          ? await mediaDevices.getUserMedia({ video: { width: { ideal: 1280 }, height: { ideal: 720 } } })
          : await mediaDevices.getDisplayMedia({ video: true });
      element('welcome').hidden = true;
      await this.open(() => openStream(stream, kind));
    } catch (error) {
      say(texts.errors[kind](wordsOf(error)), true);
    }
  }

  private keys(): void {
    window.addEventListener('keydown', event => {
      const target = event.target as HTMLElement;
      if (element<HTMLDialogElement>('save').open || target.closest('input:not([type=range]), select, textarea')) return;
      const command = event.ctrlKey || event.metaKey;
      const key = event.key.toLowerCase();
      if (command && key === 'z') {
        event.preventDefault();
        if (event.shiftKey) this.store.redo();
        else this.store.undo();
      } else if (command && key === 'y') {
        event.preventDefault();
        this.store.redo();
      } else if (key === ' ' && !target.closest('button') && document.body.classList.contains('moves')) {
        event.preventDefault();
        this.player.toggle();
      }
    });
  }
}

async function begin(): Promise<void> {
  const worker = new EngineWorker();
  const described = await worker.ask('describe', null).catch(error => {
    say(`${texts.errors.engine} ${wordsOf(error)}`, true);
    throw error;
  });
  let page: Page | undefined;
  const store = new Store(described, (state, dragging) => page?.changed(state, dragging));
  page = new Page(worker, store);
  if (location.hash.length > 1) await page.look(location.hash);
  page.changed(store.state, false);
  if (!('VideoDecoder' in self)) say(texts.errors.noWebCodecs, true);
  document.body.dataset.ready = 'yes';
  const sample = await fetch('sample.jpg');
  const file = new File([await sample.blob()], 'lake.jpg', { type: 'image/jpeg' });
  if (!element('welcome').hidden) await page.open(() => openFile(file, worker));
}

void begin();
if ('serviceWorker' in navigator && !location.hash.includes('no-store')) {
  void navigator.serviceWorker.register('sw.js').catch(() => undefined);
}
