/** Looks of settings. */

import { Look } from '../../pkg/polyreel_wasm';
import type { Mask, Settings } from '../messages';

/** The look of settings; the caller frees it. */
export function lookOf(settings: Settings, mask: Mask | null): Look {
  const { focus, ...others } = settings;
  const painted = focus === 'focus.png';
  const look = new Look(JSON.stringify(painted ? others : settings));
  if (painted && mask) look.setMask(mask.weights, mask.width, mask.height);
  return look;
}
