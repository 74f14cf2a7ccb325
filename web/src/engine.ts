/** Calls of a worker's jobs, from the page. */

import type { Job, Jobs, Reply } from './messages';

interface Waiting {
  resolve: (result: never) => void;
  reject: (error: Error) => void;
  progress?: (share: number, frame: number) => void;
}

/** A worker with an engine in it. */
export class EngineWorker {
  private readonly worker = new Worker('worker.js', { type: 'module' });
  private readonly waiting = new Map<number, Waiting>();
  private last = 0;

  constructor() {
    this.worker.onmessage = ({ data }: MessageEvent<Reply>) => this.answer(data);
    this.worker.onerror = event => this.fail(new Error(event.message || 'The engine did not start.'));
  }

  /** Asks for a job; what is in `transfer` goes over to the worker. */
  ask<J extends Job>(
    name: J,
    job: Jobs[J]['job'],
    transfer: Transferable[] = [],
    progress?: (share: number, frame: number) => void,
  ): Promise<Jobs[J]['result']> {
    const number = ++this.last;
    return new Promise((resolve, reject) => {
      this.waiting.set(number, { resolve, reject, progress });
      this.worker.postMessage({ number, name, job }, transfer);
    });
  }

  /** Ends it at once, whatever it does. */
  end(): void {
    this.worker.terminate();
    this.fail(new DOMException('cancelled', 'AbortError'));
  }

  private answer(reply: Reply): void {
    const waiting = this.waiting.get(reply.number);
    if (!waiting) return;
    if ('progress' in reply) {
      waiting.progress?.(reply.progress, reply.frame);
      return;
    }
    this.waiting.delete(reply.number);
    if ('error' in reply) waiting.reject(new Error(reply.error));
    else waiting.resolve(reply.result as never);
  }

  private fail(error: Error): void {
    for (const { reject } of this.waiting.values()) reject(error);
    this.waiting.clear();
  }
}
