/** What a page and the worker of one of its streams say to each other. */
import type { Focus, View, Welcome } from './protocol';
import type { Change } from './session';

export type ToWorker =
  | { type: 'open'; url: string; token: string }
  | { type: 'view'; view: View }
  | { type: 'isovalue'; isovalue: number }
  | { type: 'focus'; focus: readonly Focus[] }
  | { type: 'shown'; transaction: bigint };

/** Whether the service is there. `lost`: it was, or it never was; it is tried again and again. */
export type Connection = 'connecting' | 'open' | 'lost';

export type FromWorker =
  | { type: 'connection'; connection: Connection }
  | { type: 'welcome'; welcome: Welcome }
  | { type: 'change'; change: Change; receivedBytes: number }
  | { type: 'refused'; why: string };
