/** All that a person has chosen: what the page's address says. */
import type { Pose } from '../controls/pose';
import type { Shading } from '../scene/surface-material';
import type { Vector } from '../stream/protocol';

export interface SurfaceState {
  /** Distinguishes surfaces while the page is open. */
  readonly key: number;
  readonly isovalue: number;
  readonly colour: string; // #rrggbb
  readonly opacity: number; // 0.05 to 1
  readonly visible: boolean;
}

export const AXES = ['x', 'y', 'z'] as const;

export interface ClipState {
  readonly axis: 0 | 1 | 2;
  /** Where the plane crosses the scene's box: 0 to 1. */
  readonly at: number;
  /** Which side is left out. */
  readonly flipped: boolean;
}

/** A ball in which the surface is finer than the view needs. */
export interface SpotState {
  readonly centre: Vector; // [world]
  readonly radius: number; // [world]
  readonly error: number; // [world]
}

export interface ViewState {
  readonly scene: string | null;
  readonly pose: Pose | null; // null: as the scene suggests
  readonly flying: boolean;
  readonly pixelError: number | null; // [px]; null: as suits the scene
  readonly surfaces: readonly SurfaceState[];
  readonly shading: Shading;
  readonly wireframe: boolean;
  readonly clip: ClipState | null;
  readonly spots: readonly SpotState[];
}

export const LEAST_PIXEL_ERROR = 0.5;
export const MOST_PIXEL_ERROR = 64;
/** What a scene is first shown with: landscapes go on and on, and cost much. */
export const VOLUME_PIXEL_ERROR = 3;
export const LAND_PIXEL_ERROR = 8;
export const MOST_SURFACES = 6;
/** As many as the protocol takes. */
export const MOST_SPOTS = 64;

export const INITIAL_STATE: ViewState = {
  scene: null,
  pose: null,
  flying: false,
  pixelError: null,
  surfaces: [],
  shading: 'surface',
  wireframe: false,
  clip: null,
  spots: [],
};

const COLOURS = ['#e8dcc4', '#d8694a', '#5794d0', '#74ad61', '#b97bb4', '#dba93a'];

let lastKey = 0;

export function newSurface(isovalue: number, others: readonly SurfaceState[]): SurfaceState {
  const colour = COLOURS.find((one) => others.every((other) => other.colour !== one));
  return {
    key: ++lastKey,
    isovalue,
    colour: colour ?? COLOURS[0],
    opacity: 1,
    visible: true,
  };
}
