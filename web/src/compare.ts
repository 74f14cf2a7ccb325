/** The slider between the source and the picture. */

import { element } from './dom';

const STEP = 5;

export class Compare {
  private share = 50;
  private readonly stage = element('stage');
  private readonly handle = element('handle');
  private readonly button = element('compare');

  constructor() {
    this.button.onclick = () => this.set(!this.isOn);
    this.handle.onpointerdown = event => {
      this.handle.setPointerCapture(event.pointerId);
      event.preventDefault();
      this.handle.focus();
    };
    this.handle.onpointermove = event => {
      if (!this.handle.hasPointerCapture(event.pointerId)) return;
      const { left, width } = this.stage.getBoundingClientRect();
      this.move((100 * (event.clientX - left)) / width);
    };
    this.handle.onkeydown = event => {
      const steps: Record<string, number> = { ArrowLeft: -STEP, ArrowRight: STEP, Home: -100, End: 100 };
      const step = steps[event.key];
      if (step === undefined) return;
      event.preventDefault();
      this.move(this.share + step);
    };
    this.set(false);
  }

  private get isOn(): boolean {
    return this.button.getAttribute('aria-pressed') === 'true';
  }

  set(on: boolean): void {
    this.button.setAttribute('aria-pressed', String(on));
    this.handle.hidden = !on;
    this.stage.dataset.compare = on ? 'on' : 'off';
    if (on) this.move(50);
    else this.stage.style.setProperty('--split', '0%');
  }

  private move(share: number): void {
    this.share = Math.min(100, Math.max(0, share));
    this.stage.style.setProperty('--split', `${this.share}%`);
    this.handle.setAttribute('aria-valuenow', String(Math.round(this.share)));
  }
}
