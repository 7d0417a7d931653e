/** The thread of one stream: keeps the connection, decodes what comes in. */
import { MeshoptDecoder } from 'three/examples/jsm/libs/meshopt_decoder.module.js';
import { buffersOf } from './batch';
import type { FromWorker, ToWorker } from './messages';
import { PROTOCOL } from './protocol';
import { Session } from './session';

const FIRST_DELAY = 500; // before a lost service is tried again [ms]
const LONGEST_DELAY = 10_000;

let socket: WebSocket | null = null;
let delay = FIRST_DELAY;
let receivedBytes = 0;

function tell(message: FromWorker, transfer: Transferable[] = []): void {
  self.postMessage(message, { transfer });
}

const session = new Session(MeshoptDecoder, {
  send: (bytes) => socket?.send(bytes),
  welcomed: (welcome) => {
    delay = FIRST_DELAY;
    tell({ type: 'welcome', welcome });
  },
  changed: (change) => {
    tell({ type: 'change', change, receivedBytes }, buffersOf(change.batch));
  },
  refused: (why) => tell({ type: 'refused', why }),
});

function connect(url: string, token: string): void {
  tell({ type: 'connection', connection: 'connecting' });
  const mine = new WebSocket(url, token ? [PROTOCOL, `bearer.${token}`] : [PROTOCOL]);
  socket = mine;
  mine.binaryType = 'arraybuffer';
  mine.onopen = () => {
    tell({ type: 'connection', connection: 'open' });
    session.open();
  };
  mine.onmessage = ({ data }) => {
    const bytes = new Uint8Array(data as ArrayBuffer);
    receivedBytes += bytes.length;
    try {
      session.receive(bytes);
    } catch (error) {
      // the service and this page disagree on what is shown: begin anew with nothing
      session.forgetPayloads();
      mine.close();
      tell({ type: 'refused', why: error instanceof Error ? error.message : String(error) });
    }
  };
  mine.onclose = () => {
    session.close();
    socket = null;
    tell({ type: 'connection', connection: 'lost' });
    setTimeout(() => connect(url, token), delay);
    delay = Math.min(2 * delay, LONGEST_DELAY);
  };
}

self.onmessage = async ({ data }: MessageEvent<ToWorker>) => {
  switch (data.type) {
    case 'open':
      await MeshoptDecoder.ready;
      connect(data.url, data.token);
      return;
    case 'view':
      session.setView(data.view);
      return;
    case 'isovalue':
      session.setIsovalue(data.isovalue);
      return;
    case 'focus':
      session.setFocus(data.focus);
      return;
    case 'shown':
      session.acknowledge(data.transaction);
  }
};
