/** The settings, their history, and the address that has them. */

import type { Described, Mask, Settings } from './messages';

export interface State {
  settings: Settings;
  mask: Mask | null;
}

/** Options whose values are numbers where they are set at all. */
const NUMBERS = new Set(['refine', 'hex-density']);

/** How many steps back there are. */
const MOST = 200;

export class Store {
  private past: State[] = [];
  private future: State[] = [];
  private current: State = { settings: {}, mask: null };
  /** What is being dragged: its steps are undone together. */
  private gesture: string | null = null;

  constructor(
    readonly described: Described,
    private readonly changed: (state: State, dragging: boolean) => void,
  ) {}

  get state(): State {
    return this.current;
  }

  get canUndo(): boolean {
    return this.past.length > 0;
  }

  get canRedo(): boolean {
    return this.future.length > 0;
  }

  /** All options, those of the preset and the defaults included. */
  get values(): Settings {
    const { preset } = this.current.settings;
    const base = this.described.presets.find(({ name }) => name === preset);
    return { ...this.described.defaults, ...base?.options, ...this.current.settings };
  }

  /** Changes options; those of one gesture are one step. */
  set(changes: Settings, gesture: string | null = null): void {
    this.step({ ...this.current, settings: { ...this.current.settings, ...changes } }, gesture);
  }

  /** Other settings in place of all. A painted focus stays. */
  replace(settings: Settings): void {
    const { mask } = this.current;
    this.step({ settings: mask ? { ...settings, focus: 'focus.png' } : settings, mask }, null);
  }

  paint(mask: Mask | null): void {
    this.aim(mask && 'focus.png', mask);
  }

  /** Has the engine find where facets are small, in place of a mask. */
  focus(found: string | null): void {
    this.aim(found, null);
  }

  private aim(focus: string | null, mask: Mask | null): void {
    const { focus: _, ...settings } = this.current.settings;
    this.step({ settings: focus ? { ...settings, focus } : settings, mask }, null);
  }

  /** A gesture is over: the next change is a step of its own. */
  settle(): void {
    if (this.gesture === null) return;
    this.gesture = null;
    this.changed(this.current, false);
  }

  undo(): void {
    this.go(this.past, this.future);
  }

  redo(): void {
    this.go(this.future, this.past);
  }

  private step(next: State, gesture: string | null): void {
    if (gesture === null || gesture !== this.gesture) {
      this.past.push(this.current);
      if (this.past.length > MOST) this.past.shift();
      this.future = [];
    }
    this.gesture = gesture;
    this.current = next;
    this.changed(next, gesture !== null);
  }

  private go(from: State[], to: State[]): void {
    const state = from.pop();
    if (!state) return;
    to.push(this.current);
    this.gesture = null;
    this.current = state;
    this.changed(state, false);
  }

  /** The settings as the part of the address after `#`. A painted focus is no part of it. */
  toAddress(): string {
    const parameters = new URLSearchParams();
    for (const [name, value] of Object.entries(this.current.settings)) {
      if (value === undefined || (name === 'preset' && value === null)) continue;
      if (name === 'focus' && this.current.mask) continue;
      parameters.set(name, typeof value === 'object' ? JSON.stringify(value) : String(value));
    }
    return parameters.toString();
  }

  /** The settings of an address. */
  fromAddress(hash: string): Settings {
    const settings: Settings = {};
    for (const [name, text] of new URLSearchParams(hash.replace(/^#/, ''))) {
      const usual = this.described.defaults[name];
      if (name === 'focus' && text === 'focus.png') continue;
      if (text === 'null' || text.startsWith('{')) settings[name] = JSON.parse(text);
      else if (typeof usual === 'number' || NUMBERS.has(name)) settings[name] = Number(text);
      else settings[name] = text;
    }
    return settings;
  }
}
