import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  distanceOf,
  dot,
  forwardOf,
  length,
  looked,
  moved,
  normalized,
  orbited,
  type Pose,
  rayThrough,
  rightOf,
  subtract,
  upOf,
  zoomed,
} from '../src/controls/pose';
import { fromAddress, toAddress } from '../src/state/address';
import { INITIAL_STATE, newSurface, type ViewState } from '../src/state/view-state';
import { random } from './random';

const plain = (state: ViewState) => ({
  ...state,
  surfaces: state.surfaces.map(({ key: _, ...rest }) => rest),
});

test('an address leads back to the state that it is of', () => {
  const first = newSurface(-512.25, []);
  const state: ViewState = {
    scene: '0123456789abcdef0123456789abcdef',
    pose: { eye: [1.5, -2e-7, 3e9], target: [0, 0, 1], up: [0, 0, 1] },
    flying: true,
    pixelError: 5.5,
    surfaces: [first, { ...newSurface(1e-9, [first]), colour: '#a0b1c2', opacity: 0.35, visible: false }],
    shading: 'levels',
    wireframe: true,
    clip: { axis: 1, at: 0.25, flipped: true },
    spots: [{ centre: [1, 2, 3], radius: 0.5, error: 0.001 }],
  };
  const address = toAddress(state);
  assert.deepEqual(plain(fromAddress(address)), plain(state));
  assert.equal(new URL(`http://a/#${address}`).hash, `#${address}`); // needs no escapes
  assert.equal(toAddress(fromAddress(address)), address);
});

test('addresses that make no sense lead somewhere', () => {
  assert.deepEqual(fromAddress(''), INITIAL_STATE);
  const odd = fromAddress(
    'scene=x&iso=&iso=abc&iso=5_zz_9&eye=1_2&target=1_2_3&error=-7&show=never&clip=w_1&clip=&spot=1_2_3_-1_1&spot=1',
  );
  assert.equal(odd.surfaces.length, 1);
  assert.equal(odd.surfaces[0].opacity, 1);
  assert.match(odd.surfaces[0].colour, /^#[0-9a-f]{6}$/);
  assert.deepEqual([odd.pose, odd.clip, odd.spots.length, odd.shading], [null, null, 0, 'surface']);
  assert.equal(odd.pixelError, 0.5);
  assert.equal(fromAddress('scene=x&eye=1_2_3&target=1_2_3').pose, null);
  assert.equal(fromAddress(`scene=x${'&iso=1'.repeat(50)}`).surfaces.length, 6);
  const full = 'scene=a&iso=1_aabbcc_0.5&eye=1_2_3&target=4_5_6&error=3&clip=x_0.5&spot=1_2_3_4_5';
  for (let size = 0; size <= full.length; ++size) fromAddress(full.slice(0, size));
});

const start: Pose = { eye: [4, -3, 2], target: [0.5, 0.25, -0.5], up: [0, 0, 1] };
const near = (a: number, b: number) => assert.ok(Math.abs(a - b) < 1e-9 * Math.max(1, Math.abs(b)), `${a} ${b}`);

test('turning around keeps the distance, and never goes over the top', () => {
  const next = random(7);
  let pose = start;
  for (let step = 0; step < 200; ++step) {
    pose = orbited(pose, (next() - 0.5) * 3, (next() - 0.5) * 3);
    near(distanceOf(pose), distanceOf(start));
    assert.ok(pose.target === start.target);
    assert.ok(Math.abs(dot(forwardOf(pose), pose.up)) < 0.9999);
    assert.ok(dot(upOf(pose), pose.up) > 0);
    near(dot(rightOf(pose), forwardOf(pose)), 0);
  }
  // turning there and back is where one was
  const back = orbited(orbited(start, 0.7, 0), -0.7, 0);
  back.eye.forEach((value, axis) => near(value, start.eye[axis]));
});

test('looking around keeps the place; moving keeps the direction', () => {
  const around = looked(start, 0.4, -0.2);
  assert.deepEqual(around.eye, start.eye);
  near(distanceOf(around), distanceOf(start));
  const away = moved(start, 1, 2, 3);
  near(length(subtract(away.eye, start.eye)), Math.hypot(1, 2, 3));
  near(dot(forwardOf(away), forwardOf(start)), 1);
  near(dot(subtract(away.eye, start.eye), rightOf(start)), 1);
});

test('what is under the cursor stays there while one comes nearer', () => {
  const ray = rayThrough(start, 0.3, -0.6, 1.5);
  near(dot(ray, forwardOf(start)), 1);
  const place = start.eye.map((value, axis) => value + 5 * ray[axis]) as [number, number, number];
  const closer = zoomed(start, 0.2, place);
  near(dot(normalized(subtract(place, closer.eye)), normalized(ray)), 1);
  near(length(subtract(place, closer.eye)), 0.2 * length(subtract(place, start.eye)));
});
