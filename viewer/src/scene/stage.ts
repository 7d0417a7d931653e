/** Draws surfaces from somewhere: owns the device's context and all that is drawn with it. */
import {
  Color,
  Group,
  type IUniform,
  Matrix4,
  Mesh,
  PerspectiveCamera,
  Scene,
  type ShaderMaterial,
  Vector3,
  Vector4,
  WebGLRenderer,
} from 'three';
import {
  distanceOf,
  FIELD_OF_VIEW,
  forwardOf,
  length,
  type Pose,
  rayThrough,
  subtract,
  upOf,
} from '../controls/pose';
import type { Vector, Welcome } from '../stream/protocol';
import type { Change } from '../stream/session';
import { toField, toWorld } from '../stream/transform';
import { SurfaceBuffers } from './surface-buffers';
import { MOST_MARKS, NO_CLIP, SHADINGS, type Shading, surfaceMaterial } from './surface-material';

export interface SurfaceLook {
  readonly colour: string;
  readonly opacity: number;
  readonly visible: boolean;
}

export interface StageLook {
  readonly shading: Shading;
  readonly wireframe: boolean;
  readonly isLand: boolean;
  /** What lies where `dot(normal, world) > offset` is left out. */
  readonly clip: { readonly normal: Vector; readonly offset: number } | null;
  /** Balls to be marked. */
  readonly spots: readonly { readonly centre: Vector; readonly radius: number }[];
}

/** One isosurface on the stage. */
export class StagedSurface {
  readonly buffers = new SurfaceBuffers();
  readonly group = new Group();
  readonly fill = surfaceMaterial();
  readonly depth = surfaceMaterial();
  readonly lines = surfaceMaterial();
  welcome: Welcome | null = null;
  anchor: Vector = [0, 0, 0];
  look: SurfaceLook = { colour: '#ccc', opacity: 1, visible: true };
  isovalue = 0;

  constructor() {
    // drawn first where the surface is transparent, so that only what is in front of it shows
    this.depth.colorWrite = false;
    this.fill.polygonOffset = true;
    this.depth.polygonOffset = true;
    for (const material of [this.fill, this.depth]) {
      material.polygonOffsetFactor = 1;
      material.polygonOffsetUnits = 1;
    }
    this.lines.wireframe = true;
    this.lines.uniforms.look.value = 3;
    for (const material of [this.depth, this.fill, this.lines]) {
      const mesh = new Mesh(this.buffers.geometry, material);
      mesh.frustumCulled = false;
      mesh.matrixAutoUpdate = false;
      this.group.add(mesh);
    }
    this.group.matrixAutoUpdate = false;
  }

  get materials(): ShaderMaterial[] {
    return [this.fill, this.depth, this.lines];
  }

  apply(change: Change): void {
    this.buffers.apply(change.batch);
    this.anchor = change.anchor;
    this.isovalue = change.isovalue;
  }

  dispose(): void {
    this.buffers.dispose();
    for (const material of this.materials) material.dispose();
  }
}

export class Stage {
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera();
  private readonly surfaces = new Set<StagedSurface>();
  private pose: Pose = { eye: [3, 3, 3], target: [0, 0, 0], up: [0, 0, 1] };
  private look: StageLook = { shading: 'surface', wireframe: false, isLand: false, clip: null, spots: [] };
  private lineColour = new Color(0);
  private frame = 0;
  /** Called after each picture with the milliseconds that giving it to the device took. */
  onFrame: (milliseconds: number) => void = () => {};

  /** Throws if the browser has no WebGL 2. */
  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setClearColor(0, 0);
    // nothing that draws is right before the context is back, and then all of it is uploaded anew
    canvas.addEventListener('webglcontextrestored', () => this.invalidate());
  }

  add(surface: StagedSurface): void {
    this.surfaces.add(surface);
    this.scene.add(surface.group);
    this.invalidate();
  }

  remove(surface: StagedSurface): void {
    this.surfaces.delete(surface);
    this.scene.remove(surface.group);
    surface.dispose();
    this.invalidate();
  }

  setPose(pose: Pose): void {
    this.pose = pose;
    this.invalidate();
  }

  setLook(look: StageLook): void {
    this.look = look;
    this.invalidate();
  }

  setLineColour(colour: string): void {
    this.lineColour = new Color(colour);
    this.invalidate();
  }

  resize(width: number, height: number, pixelRatio: number): void {
    this.renderer.setPixelRatio(pixelRatio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(height, 1);
    this.invalidate();
  }

  /** Draws soon. */
  invalidate(): void {
    this.frame ||= requestAnimationFrame(() => {
      this.frame = 0;
      this.draw();
    });
  }

  /** The picture as it is now, as a PNG. */
  async picture(background: string): Promise<Blob> {
    this.renderer.setClearColor(new Color(background), 1);
    this.draw();
    const blob = new Promise<Blob | null>((done) => this.canvas.toBlob(done, 'image/png'));
    this.renderer.setClearColor(0, 0);
    this.invalidate();
    const made = await blob;
    if (!made) throw new Error('the browser made no picture');
    return made;
  }

  /** How far the nearest cell of what is shown is from the eye [world]. */
  clearance(): number {
    return this.depthRange()[0];
  }

  /** Where what is shown is at a point of the picture, x and y from -1 to 1. */
  pick(x: number, y: number): Vector | null {
    const direction = rayThrough(this.pose, x, y, this.camera.aspect);
    let nearest = Infinity;
    for (const surface of this.surfaces) {
      if (!surface.welcome || !surface.look.visible) continue;
      const m = surface.welcome.worldFromField;
      const eye = toField(m, this.pose.eye);
      const ahead = toField(m, [
        this.pose.eye[0] + direction[0],
        this.pose.eye[1] + direction[1],
        this.pose.eye[2] + direction[2],
      ]);
      const along = surface.buffers.raycast(subtract(eye, surface.anchor), subtract(ahead, eye));
      if (along !== null) nearest = Math.min(nearest, along);
    }
    if (nearest === Infinity) return null;
    return [
      this.pose.eye[0] + nearest * direction[0],
      this.pose.eye[1] + nearest * direction[1],
      this.pose.eye[2] + nearest * direction[2],
    ];
  }

  private draw(): void {
    const begin = performance.now();
    // The eye is always at the origin: what is far from the world's is as steady as what is near.
    const pose = this.pose;
    this.camera.up.set(...upOf(pose));
    this.camera.position.set(0, 0, 0);
    this.camera.lookAt(...forwardOf(pose));
    this.camera.fov = (FIELD_OF_VIEW * 180) / Math.PI;
    [this.camera.near, this.camera.far] = this.depthRange();
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    const skyward = new Vector3(...pose.up)
      .normalize()
      .transformDirection(this.camera.matrixWorldInverse);
    for (const surface of this.surfaces) this.prepare(surface, skyward);
    this.renderer.render(this.scene, this.camera);
    this.onFrame(performance.now() - begin);
  }

  private prepare(surface: StagedSurface, skyward: Vector3): void {
    const { look, group, welcome } = surface;
    group.visible = look.visible && welcome !== null && surface.buffers.triangleCount > 0;
    if (!group.visible || !welcome) return;
    const m = welcome.worldFromField;
    const at = subtract(toWorld(m, surface.anchor), this.pose.eye);
    const matrix = new Matrix4().set(
      ...[m[0], m[3], m[6], at[0], m[1], m[4], m[7], at[1], m[2], m[5], m[8], at[2], 0, 0, 0, 1] as const,
    );
    const [depth, fill, lines] = group.children as Mesh[];
    // what is further inside is drawn first, to be seen through what is around it
    const order = 3 * this.rank(surface);
    [depth, fill, lines].forEach((mesh, i) => {
      mesh.matrix.copy(matrix);
      mesh.matrixWorldNeedsUpdate = true;
      mesh.renderOrder = order + i;
    });
    const isTransparent = look.opacity < 1;
    depth.visible = isTransparent;
    lines.visible = this.look.wireframe;
    surface.fill.transparent = isTransparent;
    surface.lines.transparent = isTransparent;
    surface.depth.transparent = isTransparent; // among the transparent ones, in their order
    surface.fill.depthWrite = !isTransparent;
    const set = (name: string, value: IUniform['value']) => {
      for (const material of surface.materials) material.uniforms[name].value = value;
    };
    set('opacity', look.opacity);
    set('clip', this.clip());
    set('skyward', skyward);
    set('isLand', this.look.isLand);
    const spots = this.look.spots.slice(0, MOST_MARKS);
    surface.fill.uniforms.spotCount.value = spots.length;
    spots.forEach(({ centre, radius }, i) =>
      surface.fill.uniforms.spots.value[i].set(...subtract(centre, this.pose.eye), radius),
    );
    surface.fill.uniforms.tint.value = new Color(look.colour);
    surface.fill.uniforms.look.value = SHADINGS.indexOf(this.look.shading);
    surface.lines.uniforms.tint.value = this.lineColour;
    surface.lines.uniforms.opacity.value = 0.35 * look.opacity;
    surface.lines.transparent = true;
  }

  /** Transparent surfaces with a higher isovalue are taken to be inside of others. */
  private rank(surface: StagedSurface): number {
    let rank = 0;
    for (const other of this.surfaces) if (other.isovalue > surface.isovalue) ++rank;
    return rank;
  }

  private clip(): Vector4 {
    const clip = this.look.clip;
    if (!clip) return NO_CLIP;
    const [x, y, z] = clip.normal;
    const { eye } = this.pose;
    return new Vector4(x, y, z, clip.offset - (x * eye[0] + y * eye[1] + z * eye[2]));
  }

  /** Of what is shown: how near and far from the eye it is [world]. */
  private depthRange(): [number, number] {
    let nearest = Infinity;
    let farthest = 0;
    for (const surface of this.surfaces) {
      if (!surface.welcome || !surface.look.visible) continue;
      const m = surface.welcome.worldFromField;
      const eye = subtract(toField(m, this.pose.eye), surface.anchor);
      // world units to one of the field's, at least and at most
      const scales = [0, 3, 6].map((i) => Math.hypot(m[i], m[i + 1], m[i + 2]));
      for (const box of surface.buffers.boxes()) {
        let near = 0;
        let far = 0;
        let size = 0;
        for (let axis = 0; axis < 3; ++axis) {
          const below = box[axis] - eye[axis];
          const above = eye[axis] - box[axis + 3];
          near += Math.max(below, above, 0) ** 2;
          far += Math.max(Math.abs(below), Math.abs(above)) ** 2;
          size = Math.max(size, box[axis + 3] - box[axis]);
        }
        // within a cell's box, a small part of it may be the nearest
        nearest = Math.min(nearest, Math.max(Math.sqrt(near), 0.02 * size) * Math.min(...scales));
        farthest = Math.max(farthest, Math.sqrt(far) * Math.max(...scales));
      }
    }
    if (nearest === Infinity) return [distanceOf(this.pose) / 100, 100 * distanceOf(this.pose)];
    return [0.9 * Math.max(nearest, farthest * 1e-6), 1.1 * farthest];
  }
}

/** How much of the world a pixel takes, a distance from the eye. */
export function pixelSize(pose: Pose, at: Vector, pixels: number): number {
  return (2 * length(subtract(at, pose.eye)) * Math.tan(FIELD_OF_VIEW / 2)) / pixels;
}
