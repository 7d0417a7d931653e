/** The state as the part of an address behind the #, which no server ever sees, and back. */
import type { Pose } from '../controls/pose';
import { SHADINGS } from '../scene/surface-material';
import type { Vector } from '../stream/protocol';
import {
  AXES,
  type ClipState,
  INITIAL_STATE,
  LEAST_PIXEL_ERROR,
  MOST_PIXEL_ERROR,
  MOST_SPOTS,
  MOST_SURFACES,
  newSurface,
  type SpotState,
  type SurfaceState,
  type ViewState,
} from './view-state';

/** Digits that a place needs, so that the picture is the same. */
const DIGITS = 8;

export function toAddress(state: ViewState): string {
  if (!state.scene) return '';
  const parts: [string, string][] = [['scene', state.scene]];
  for (const surface of state.surfaces)
    parts.push([
      'iso',
      [
        number(surface.isovalue),
        surface.colour.slice(1),
        number(surface.opacity),
        ...(surface.visible ? [] : ['hidden']),
      ].join('_'),
    ]);
  if (state.pose) parts.push(['eye', numbers(state.pose.eye)], ['target', numbers(state.pose.target)]);
  if (state.flying) parts.push(['fly', '1']);
  if (state.pixelError !== null) parts.push(['error', number(state.pixelError)]);
  if (state.shading !== INITIAL_STATE.shading) parts.push(['show', state.shading]);
  if (state.wireframe) parts.push(['wire', '1']);
  if (state.clip) {
    const { axis, at, flipped } = state.clip;
    parts.push(['clip', `${AXES[axis]}_${number(at)}${flipped ? '_flipped' : ''}`]);
  }
  for (const spot of state.spots)
    parts.push(['spot', `${numbers(spot.centre)}_${number(spot.radius)}_${number(spot.error)}`]);
  return parts.map(([name, value]) => `${name}=${value}`).join('&');
}

/**
 * What makes no sense is left out: addresses are edited by hand, and cut short by mail.
 * @param up  of the scene: an address doesn't have it
 */
export function fromAddress(text: string, up: Vector = [0, 0, 1]): ViewState {
  const query = new URLSearchParams(text);
  const surfaces: SurfaceState[] = [];
  for (const one of query.getAll('iso').slice(0, MOST_SURFACES)) {
    const surface = surfaceOf(one, surfaces);
    if (surface) surfaces.push(surface);
  }
  const spots = query.getAll('spot').map(spotOf).filter((spot) => spot !== null);
  const eye = vectorOf(query.get('eye'));
  const target = vectorOf(query.get('target'));
  const pose: Pose | null = eye && target && eye.some((x, i) => x !== target[i]) ? { eye, target, up } : null;
  const error = numberOf(query.get('error'));
  return {
    scene: query.get('scene') || null,
    surfaces,
    pose,
    flying: query.get('fly') === '1',
    pixelError:
      error === null ? null : Math.min(Math.max(error, LEAST_PIXEL_ERROR), MOST_PIXEL_ERROR),
    shading: SHADINGS.find((one) => one === query.get('show')) ?? INITIAL_STATE.shading,
    wireframe: query.get('wire') === '1',
    clip: clipOf(query.get('clip')),
    spots: spots.slice(0, MOST_SPOTS),
  };
}

function number(value: number): string {
  return String(Number(value.toPrecision(DIGITS)));
}

function numbers(vector: Vector): string {
  return vector.map(number).join('_');
}

function numberOf(text: string | null | undefined): number | null {
  const value = text ? Number(text) : NaN;
  return Number.isFinite(value) ? value : null;
}

function vectorOf(text: string | null): Vector | null {
  const [x, y, z] = (text ?? '').split('_').map(numberOf);
  return x != null && y != null && z != null ? [x, y, z] : null;
}

function surfaceOf(text: string, others: readonly SurfaceState[]): SurfaceState | null {
  const [isovalue, colour, opacity, visibility] = text.split('_');
  const value = numberOf(isovalue);
  if (value === null) return null;
  const surface = newSurface(value, others);
  return {
    ...surface,
    colour: /^[0-9a-f]{6}$/i.test(colour ?? '') ? `#${colour.toLowerCase()}` : surface.colour,
    opacity: Math.min(Math.max(numberOf(opacity) ?? 1, 0.05), 1),
    visible: visibility !== 'hidden',
  };
}

function clipOf(text: string | null): ClipState | null {
  const [name, at, side] = (text ?? '').split('_');
  const axis = AXES.findIndex((one) => one === name);
  const place = numberOf(at);
  if (axis < 0 || place === null) return null;
  return {
    axis: axis as 0 | 1 | 2,
    at: Math.min(Math.max(place, 0), 1),
    flipped: side === 'flipped',
  };
}

function spotOf(text: string): SpotState | null {
  const [x, y, z, radius, error] = text.split('_').map(numberOf);
  if (x == null || y == null || z == null || radius == null || error == null) return null;
  return radius > 0 && error > 0 ? { centre: [x, y, z], radius, error } : null;
}
