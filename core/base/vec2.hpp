/// A point or a vector in a plane: x runs right along columns, y runs down along rows.
#pragma once

#include <cmath>

namespace ovws {

struct Vec2 {
  double x = 0.0;
  double y = 0.0;

  friend Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
  friend Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
  friend Vec2 operator*(double k, Vec2 a) { return {k * a.x, k * a.y}; }
  friend bool operator==(Vec2 a, Vec2 b) { return a.x == b.x && a.y == b.y; }
};

inline double norm(Vec2 a) {
  return std::sqrt(a.x * a.x + a.y * a.y);
}

/// A disc in a plane.
struct Disc {
  Vec2 centre;
  double radius = 0.0;

  bool contains(Vec2 at) const { return norm(at - centre) <= radius; }
};

}  // namespace ovws
