/** Where somebody looks from, and how that moves. All in world coordinates, in doubles. */
import type { Vector } from '../stream/protocol';

export interface Pose {
  readonly eye: Vector;
  /** What is turned around, and looked at. */
  readonly target: Vector;
  /** The scene's; never changes while moving. */
  readonly up: Vector;
}

/** The whole vertical angle of every view [rad]. */
export const FIELD_OF_VIEW = Math.PI / 4;
/** How near to straight up or down one may look [rad]. */
const LEAST_ANGLE = 0.02;

export const add = (a: Vector, b: Vector): Vector => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a: Vector, b: Vector): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a: Vector, s: number): Vector => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a: Vector, b: Vector): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = (a: Vector): number => Math.hypot(...a);
export const normalized = (a: Vector): Vector => scale(a, 1 / (length(a) || 1));
export const cross = (a: Vector, b: Vector): Vector => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

/** Turns a vector by an angle around a unit axis (Rodrigues). */
export function turned(v: Vector, axis: Vector, angle: number): Vector {
  const c = Math.cos(angle);
  const along = scale(axis, dot(axis, v) * (1 - c));
  return add(add(scale(v, c), scale(cross(axis, v), Math.sin(angle))), along);
}

export function forwardOf(pose: Pose): Vector {
  return normalized(subtract(pose.target, pose.eye));
}

export function rightOf(pose: Pose): Vector {
  const right = cross(forwardOf(pose), pose.up);
  if (length(right) > 1e-9) return normalized(right);
  const other: Vector = Math.abs(pose.up[0]) < 0.5 ? [1, 0, 0] : [0, 1, 0];
  return normalized(cross(pose.up, other));
}

/** The view's own upward direction: across forward and right. */
export function upOf(pose: Pose): Vector {
  return cross(rightOf(pose), forwardOf(pose));
}

export function distanceOf(pose: Pose): number {
  return length(subtract(pose.target, pose.eye));
}

/** Turns a direction to the side and upwards, but not beyond straight up or down. */
function swung(pose: Pose, direction: Vector, yaw: number, pitch: number): Vector {
  const up = normalized(pose.up);
  const angle = Math.acos(Math.min(Math.max(dot(normalized(direction), up), -1), 1));
  const most = angle - LEAST_ANGLE;
  const least = angle - (Math.PI - LEAST_ANGLE);
  const side = rightOf(pose);
  const raised = turned(direction, side, Math.min(Math.max(pitch, least), Math.max(most, least)));
  return turned(raised, up, yaw);
}

/** Goes around the target: what is seen turns with the hand. Angles in radians. */
export function orbited(pose: Pose, yaw: number, pitch: number): Pose {
  const forward = swung(pose, subtract(pose.target, pose.eye), yaw, pitch);
  return { ...pose, eye: subtract(pose.target, forward) };
}

/** Looks around from where one is. */
export function looked(pose: Pose, yaw: number, pitch: number): Pose {
  const forward = swung(pose, subtract(pose.target, pose.eye), yaw, pitch);
  return { ...pose, target: add(pose.eye, forward) };
}

/** Moves eye and target alike: to the right, up and forward [world]. */
export function moved(pose: Pose, right: number, up: number, forward: number): Pose {
  const by = add(
    add(scale(rightOf(pose), right), scale(upOf(pose), up)),
    scale(forwardOf(pose), forward),
  );
  return { ...pose, eye: add(pose.eye, by), target: add(pose.target, by) };
}

/** Comes nearer to a place, or goes from it: distances to it grow by the factor. */
export function zoomed(pose: Pose, factor: number, place: Vector = pose.target): Pose {
  return {
    ...pose,
    eye: add(place, scale(subtract(pose.eye, place), factor)),
    target: add(place, scale(subtract(pose.target, place), factor)),
  };
}

/** The direction of a point of the picture, x and y from -1 to 1, of a length of 1 along forward. */
export function rayThrough(pose: Pose, x: number, y: number, aspect: number): Vector {
  const high = Math.tan(FIELD_OF_VIEW / 2);
  return add(
    forwardOf(pose),
    add(scale(rightOf(pose), x * high * aspect), scale(upOf(pose), y * high)),
  );
}
