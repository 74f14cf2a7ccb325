/** Focus by painting: more and smaller facets where the brush was, and on faces that were clicked. */

import { element, make } from './dom';
import type { Face, Mask } from './messages';
import { texts } from './texts';

/** The longest side of a mask: the engine asks no finer. */
const LONGEST = 192;
/** The brush's radius as a share of the shorter side, and what a touch paints. */
const RADIUS = 0.09;
/** How far a face reaches beyond its box, so that its outline belongs to it. */
const REACH = 1.25;
/** What a mask says of places that nobody painted: neither more nor less than others. */
const NEUTRAL = 128;

export class Painting {
  private readonly canvas = element<HTMLCanvasElement>('paint');
  private readonly button = element('focus');
  private readonly clear = element('unfocus');
  private readonly context = this.canvas.getContext('2d', { willReadFrequently: true });
  private readonly rings = element('faces');
  private last: [number, number] | null = null;
  private round = 0;

  /** `painted` is called after each stroke, `find` gives the faces of the frame that is seen. */
  constructor(
    private readonly painted: (mask: Mask | null) => void,
    private readonly find: () => Promise<Face[]>,
  ) {
    this.button.onclick = () => {
      const on = this.button.getAttribute('aria-pressed') !== 'true';
      this.set(on);
      if (on) void this.look();
    };
    this.clear.onclick = () => {
      this.show(null);
      this.painted(null);
    };
    this.canvas.onpointerdown = event => {
      this.canvas.setPointerCapture(event.pointerId);
      event.preventDefault();
      this.stroke(event);
    };
    this.canvas.onpointermove = event => {
      if (this.canvas.hasPointerCapture(event.pointerId)) this.stroke(event);
    };
    this.canvas.onpointerup = () => this.lift();
    this.canvas.onpointercancel = () => this.lift();
  }

  /** Makes room for a mask of a picture of this size. */
  open(width: number, height: number): void {
    const share = LONGEST / Math.max(width, height);
    this.canvas.width = Math.max(1, Math.round(width * share));
    this.canvas.height = Math.max(1, Math.round(height * share));
    this.set(false);
    this.clear.hidden = true;
  }

  set(on: boolean): void {
    this.button.setAttribute('aria-pressed', String(on));
    this.canvas.hidden = !on;
    this.rings.hidden = !on;
    this.rings.replaceChildren();
    this.round++;
  }

  /** Rings around the faces, to be clicked. Without faces, or where they cannot be found, there is the brush. */
  private async look(): Promise<void> {
    const { round } = this;
    const faces = await this.find().catch(() => []);
    if (round !== this.round) return;
    this.rings.replaceChildren(...faces.map((face, index) => this.ring(face, index + 1)));
  }

  private ring(face: Face, number: number): HTMLElement {
    const ring = make('button', { type: 'button', class: 'face', 'aria-label': texts.face(number) });
    const percent = (share: number): string => `${100 * share}%`;
    Object.assign(ring.style, {
      left: percent(face.left),
      top: percent(face.top),
      width: percent(face.width),
      height: percent(face.height),
    });
    ring.onclick = () => {
      this.fill(face);
      ring.remove();
      this.finish();
    };
    return ring;
  }

  private fill({ left, top, width, height }: Face): void {
    const { context, canvas } = this;
    if (!context) return;
    const along = (from: number, long: number, side: number): [number, number] => [
      (from + long / 2) * side,
      (REACH * long * side) / 2,
    ];
    const [x, wide] = along(left, width, canvas.width);
    const [y, high] = along(top, height, canvas.height);
    context.fillStyle = 'rgb(255,255,255)';
    context.beginPath();
    context.ellipse(x, y, wide, high, 0, 0, 2 * Math.PI);
    context.fill();
  }

  /** Shows a mask, of an undone step for one. */
  show(mask: Mask | null): void {
    this.clear.hidden = mask === null;
    const { context, canvas } = this;
    if (!context) return;
    const picture = context.createImageData(canvas.width, canvas.height);
    const same = mask?.width === canvas.width && mask.height === canvas.height;
    for (let i = 0; i < canvas.width * canvas.height; i++) {
      const weight = mask && same ? (mask.weights[i] ?? NEUTRAL) : NEUTRAL;
      picture.data.set([255, 255, 255, Math.max(0, 2 * (weight - NEUTRAL))], 4 * i);
    }
    context.putImageData(picture, 0, 0);
  }

  private stroke(event: PointerEvent): void {
    const { context, canvas } = this;
    if (!context) return;
    const box = canvas.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * canvas.width;
    const y = ((event.clientY - box.top) / box.height) * canvas.height;
    const radius = RADIUS * Math.min(canvas.width, canvas.height);
    const [fromX, fromY] = this.last ?? [x, y];
    const steps = Math.max(1, Math.ceil(Math.hypot(x - fromX, y - fromY) / (radius / 3)));
    for (let i = 1; i <= steps; i++) {
      const [px, py] = [fromX + ((x - fromX) * i) / steps, fromY + ((y - fromY) * i) / steps];
      const soft = context.createRadialGradient(px, py, radius * 0.4, px, py, radius);
      soft.addColorStop(0, 'rgba(255,255,255,0.9)');
      soft.addColorStop(1, 'rgba(255,255,255,0)');
      context.fillStyle = soft;
      context.fillRect(px - radius, py - radius, 2 * radius, 2 * radius);
    }
    this.last = [x, y];
  }

  private lift(): void {
    if (!this.last) return;
    this.last = null;
    this.finish();
  }

  private finish(): void {
    this.clear.hidden = false;
    this.painted(this.mask());
  }

  private mask(): Mask {
    const { width, height } = this.canvas;
    const weights = new Uint8Array(width * height);
    const data = this.context?.getImageData(0, 0, width, height).data;
    for (let i = 0; i < weights.length; i++) {
      weights[i] = Math.min(255, NEUTRAL + Math.round((data?.[4 * i + 3] ?? 0) / 2));
    }
    return { width, height, weights };
  }
}

/** A mask as a picture, for `--focus`. */
export async function maskFile(mask: Mask): Promise<Blob> {
  const canvas = new OffscreenCanvas(mask.width, mask.height);
  const picture = new ImageData(mask.width, mask.height);
  mask.weights.forEach((weight, i) => picture.data.set([weight, weight, weight, 255], 4 * i));
  canvas.getContext('2d')?.putImageData(picture, 0, 0);
  return canvas.convertToBlob({ type: 'image/png' });
}
