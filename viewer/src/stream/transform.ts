/** The affine map from the field's space to the world: three columns and a translation. */
import type { Vector } from './protocol';

export function determinant(m: readonly number[]): number {
  return (
    m[0] * (m[4] * m[8] - m[5] * m[7]) -
    m[3] * (m[1] * m[8] - m[2] * m[7]) +
    m[6] * (m[1] * m[5] - m[2] * m[4])
  );
}

/** Where a point of the world lies in the field. */
export function toField(m: readonly number[], world: Vector): Vector {
  const x = world[0] - m[9];
  const y = world[1] - m[10];
  const z = world[2] - m[11];
  const scale = 1 / determinant(m);
  return [
    ((m[4] * m[8] - m[5] * m[7]) * x + (m[6] * m[5] - m[3] * m[8]) * y + (m[3] * m[7] - m[6] * m[4]) * z) * scale,
    ((m[2] * m[7] - m[1] * m[8]) * x + (m[0] * m[8] - m[6] * m[2]) * y + (m[6] * m[1] - m[0] * m[7]) * z) * scale,
    ((m[1] * m[5] - m[2] * m[4]) * x + (m[3] * m[2] - m[0] * m[5]) * y + (m[0] * m[4] - m[3] * m[1]) * z) * scale,
  ];
}

/** Where a point of the field lies in the world. */
export function toWorld(m: readonly number[], field: Vector): Vector {
  const at = (row: 0 | 1 | 2) =>
    m[row] * field[0] + m[3 + row] * field[1] + m[6 + row] * field[2] + m[9 + row];
  return [at(0), at(1), at(2)];
}
