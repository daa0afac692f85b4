// Contour lines by marching squares.

/** Segments [x1, y1, x2, y2] in pixels where `map` (size x size, NaN: no value) crosses `level`; pixel centres have integer coordinates. */
export function contour(map, size, level) {
  const segments = [];
  for (let y = 0; y + 1 < size; ++y) {
    for (let x = 0; x + 1 < size; ++x) {
      const corners = [map[y * size + x], map[y * size + x + 1], map[(y + 1) * size + x + 1], map[(y + 1) * size + x]];
      const points = crossings(corners, level, x, y);
      for (let i = 0; i + 1 < points.length; i += 2) segments.push([...points[i], ...points[i + 1]]);
    }
  }
  return segments;
}

const CORNERS = [[0, 0], [1, 0], [1, 1], [0, 1]];

/** Points where the level crosses the edges of one square; none if a corner has no value. In a saddle, pairs in the order of the edges. */
function crossings(corners, level, x, y) {
  const points = [];
  if (corners.some(Number.isNaN)) return points;
  for (let edge = 0; edge < 4; ++edge) {
    const [from, to] = [corners[edge] - level, corners[(edge + 1) % 4] - level];
    if (from >= 0 === to >= 0) continue;
    const part = from / (from - to);
    const [a, b] = [CORNERS[edge], CORNERS[(edge + 1) % 4]];
    points.push([x + a[0] + part * (b[0] - a[0]), y + a[1] + part * (b[1] - a[1])]);
  }
  return points;
}

/** Levels between `low` and `high`, multiples of `step`. */
export function levels(low, high, step) {
  const first = Math.ceil(low / step);
  return Array.from({ length: Math.max(0, Math.floor(high / step) - first + 1) }, (_, i) => (first + i) * step);
}
