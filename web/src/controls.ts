/** The controls beside the picture. */

import { element, make } from './dom';
import type { Settings } from './messages';
import type { Store } from './settings';
import { texts } from './texts';

interface Slider {
  name: string;
  label: string;
  group: string;
  least: number;
  most: number;
  step: number;
  /** What is seen of the value. */
  words: (value: number) => string;
}

const share = (value: number): string => `${Math.round(100 * value)} %`;
const pixels = (value: number): string => `${value} px`;

const SLIDERS: Slider[] = [
  { name: 'regularity', label: texts.controls.regularity, group: 'detail', least: 0, most: 1, step: 0.01, words: share },
  { name: 'coherence', label: texts.controls.coherence, group: 'detail', least: 0, most: 1, step: 0.01, words: share },
  { name: 'saturation', label: texts.controls.saturation, group: 'colour', least: 0, most: 2.5, step: 0.01, words: share },
  { name: 'contrast', label: texts.controls.contrast, group: 'colour', least: 0, most: 2, step: 0.01, words: share },
  { name: 'outline-width', label: texts.controls.outlineWidth, group: 'lines', least: 1, most: 16, step: 1, words: pixels },
  { name: 'outline-contrast', label: texts.controls.outlineContrast, group: 'lines', least: 0, most: 80, step: 1, words: String },
];

/** A number of an option; of a length, the pixels, where `side` is what it may be a share of. */
function numberOf(value: unknown, side: number): number {
  const text = String(value);
  return text.endsWith('%') ? Math.round((Number.parseFloat(text) / 100) * side) : Number.parseFloat(text);
}

/** Facets go from few to many by ratio, not by difference. */
const FEWEST = 30;
const MOST = 20_000;
const TICKS = 1000;

const toTick = (points: number): number =>
  (TICKS * Math.log(Math.max(FEWEST, points) / FEWEST)) / Math.log(MOST / FEWEST);
const toPoints = (tick: number): number => {
  const exact = FEWEST * (MOST / FEWEST) ** (tick / TICKS);
  const digits = 10 ** Math.max(0, Math.floor(Math.log10(exact)) - 1);
  return Math.round(exact / digits) * digits;
};

export class Controls {
  private readonly inputs = new Map<string, (values: Settings) => void>();
  private rendered = 0;
  /** The shorter side of the source. */
  private side = 1;

  constructor(private readonly store: Store) {
    this.points();
    for (const slider of SLIDERS) this.slider(slider);
    this.choice('fill', texts.fill, value => store.set({ fill: value }));
    this.choice('shape', texts.shape, value => store.set({ shape: value }));
    this.choice('focus', texts.focus, value => store.focus(value));
    this.outline();
  }

  /** Shows the options that hold. */
  show(): void {
    const { values } = this.store;
    for (const show of this.inputs.values()) show(values);
  }

  /** A source of this size is open. */
  sized(width: number, height: number): void {
    this.side = Math.min(width, height);
    this.show();
  }

  /** The number of points of the picture that is seen. */
  counted(points: number): void {
    this.rendered = points;
    this.inputs.get('points')?.(this.store.values);
  }

  private range(group: string, label: string, id: string, [least, most, step]: [number, number, number]) {
    const input = make('input', { type: 'range', id, min: `${least}`, max: `${most}`, step: `${step}` });
    const output = make('output', { for: id });
    const row = make('div', { class: 'slider' }, make('label', { for: id }, label), output, input);
    element(group).append(row);
    const paint = (): void => {
      const at = (100 * (Number(input.value) - least)) / (most - least);
      input.style.setProperty('--share', `${at}%`);
    };
    input.addEventListener('change', () => this.store.settle());
    return { input, output, paint };
  }

  private points(): void {
    const { input, output, paint } = this.range('detail', texts.controls.points, 'points', [0, TICKS, 1]);
    const words = (points: number): void => {
      output.textContent = points.toLocaleString('en');
      input.setAttribute('aria-valuetext', String(points));
      paint();
    };
    input.oninput = () => {
      const points = toPoints(Number(input.value));
      words(points);
      this.store.set({ points: String(points) }, 'points');
    };
    this.inputs.set('points', ({ points }) => {
      const count = /^\d+$/.test(String(points)) ? Number(points) : this.rendered;
      if (count === 0) return;
      input.value = String(Math.round(toTick(count)));
      words(count);
    });
  }

  private slider({ name, label, group, least, most, step, words }: Slider): void {
    const { input, output, paint } = this.range(group, label, name, [least, most, step]);
    const show = (value: number): void => {
      output.textContent = words(value);
      input.setAttribute('aria-valuetext', words(value));
      paint();
    };
    input.oninput = () => {
      const value = Number(input.value);
      show(value);
      // Options that may have a unit are text.
      const isText = typeof this.store.described.defaults[name] === 'string';
      this.store.set({ [name]: isText ? String(value) : value }, name);
    };
    this.inputs.set(name, values => {
      const value = numberOf(values[name], this.side);
      input.value = String(value);
      show(value);
    });
  }

  private choice(
    name: 'fill' | 'shape' | 'focus',
    words: Record<string, string>,
    choose: (value: string | null) => void,
  ): void {
    const group = element(`${name}-choice`);
    const buttons = (this.store.described.choices[name] ?? []).map(value => {
      const input = make('input', { type: 'radio', name, value: String(value), id: `${name}-${value}` });
      input.onchange = () => choose(value);
      const label = make('label', { for: input.id }, words[String(value)] ?? String(value));
      group.append(make('span', { class: 'option' }, input, label));
      return input;
    });
    this.inputs.set(name, values => {
      for (const input of buttons) input.checked = input.value === String(values[name]);
    });
  }

  private outline(): void {
    const toggle = element<HTMLInputElement>('outline');
    const colour = element<HTMLInputElement>('outline-colour');
    toggle.onchange = () => this.store.set({ outline: toggle.checked ? colour.value : null });
    colour.oninput = () => this.store.set({ outline: colour.value }, 'outline');
    colour.onchange = () => this.store.settle();
    this.inputs.set('outline', ({ outline }) => {
      const on = typeof outline === 'string';
      toggle.checked = on;
      element('lines').hidden = !on;
      colour.disabled = !on;
      if (on) colour.value = outline.slice(0, 7);
    });
  }
}
