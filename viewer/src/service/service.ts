/** What the service says of its scenes: its HTTP operations, as far as the page needs them. */
import type { Vector } from '../stream/protocol';

export interface SceneSummary {
  readonly id: string;
  readonly name: string;
  readonly source: string;
  readonly state: 'preparing' | 'ready' | 'failed' | 'uploading';
  readonly failure?: string;
  readonly kind?: string;
}

export interface SceneDescription {
  readonly kind: string;
  readonly text: string;
  readonly bounds: readonly [Vector, Vector];
  readonly isovalue: number;
  readonly value_range: readonly [number, number];
  readonly histogram: readonly number[];
  readonly view: { readonly eye: Vector; readonly target: Vector; readonly up: Vector };
  readonly terrain: boolean;
}

export interface Scene extends SceneSummary {
  readonly description?: SceneDescription;
}

export interface Formula {
  readonly name: string;
  readonly description: string;
}

export interface SourceFile {
  readonly path: string;
  readonly bytes: number;
}

/** The service said no, or nothing: status 0. */
export class ServiceError extends Error {
  constructor(
    readonly status: number,
    message: string,
  ) {
    super(message);
  }
}

const TOKEN_KEY = 'isofront-token';

export class Service {
  private readonly base = new URL('.', window.location.href);

  /** Kept until the tab is closed, and never part of an address. */
  get token(): string {
    return sessionStorage.getItem(TOKEN_KEY) ?? '';
  }

  set token(token: string) {
    sessionStorage.setItem(TOKEN_KEY, token);
  }

  streamUrl(scene: string): string {
    const url = new URL(`v1/scenes/${encodeURIComponent(scene)}/stream`, this.base);
    url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
    return url.href;
  }

  async scenes(): Promise<SceneSummary[]> {
    return (await this.ask<{ scenes: SceneSummary[] }>('v1/scenes')).scenes;
  }

  scene(id: string): Promise<Scene> {
    return this.ask<Scene>(`v1/scenes/${encodeURIComponent(id)}`);
  }

  async formulas(): Promise<Formula[]> {
    return (await this.ask<{ formulas: Formula[] }>('v1/formulas')).formulas;
  }

  async files(): Promise<SourceFile[]> {
    return (await this.ask<{ files: SourceFile[] }>('v1/files')).files;
  }

  create(scene: { name: string; formula?: string; file?: string }): Promise<Scene> {
    return this.ask<Scene>('v1/scenes', {
      method: 'POST',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify(scene),
    });
  }

  upload(file: File): Promise<Scene> {
    const query = new URLSearchParams({ file: file.name, name: file.name });
    return this.ask<Scene>(`v1/uploads?${query}`, {
      method: 'POST',
      headers: { 'Content-Type': 'application/octet-stream' },
      body: file,
    });
  }

  private async ask<T>(path: string, request: RequestInit = {}): Promise<T> {
    const headers = new Headers(request.headers);
    if (this.token) headers.set('Authorization', `Bearer ${this.token}`);
    let answer: Response;
    try {
      answer = await fetch(new URL(path, this.base), { ...request, headers });
    } catch {
      throw new ServiceError(0, 'The service is not there.');
    }
    const body = (await answer.json().catch(() => ({}))) as T & { detail?: string };
    if (!answer.ok) throw new ServiceError(answer.status, body.detail ?? `The service answered ${answer.status}.`);
    return body;
  }
}
