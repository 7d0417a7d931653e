/** One of each message of the protocol, as bytes that were not made with this code. */
import { readFileSync } from 'node:fs';

export function vectors(): Map<string, Uint8Array> {
  const path = process.env.ISOFRONT_VECTORS ?? '../tests/server/vectors';
  const all = new Map<string, Uint8Array>();
  for (const line of readFileSync(`${path}/messages.txt`, 'utf8').split('\n')) {
    const [name, hex] = line.split(' ');
    if (name && name !== '#' && hex) all.set(name, Uint8Array.from(Buffer.from(hex, 'hex')));
  }
  return all;
}
