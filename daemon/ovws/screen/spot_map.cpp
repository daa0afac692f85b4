/// Draws the map of spots, with arrows for displaced ones.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "daemon/ovws/screen/page.hpp"

namespace ovws::screen {
namespace {

constexpr float kMovedPx = 1.0F;
constexpr double kCellHeight = 2.0;  ///< height of a character cell in units of its width

struct Point {
  float x = 0, y = 0;
};

bool is_finite(float x, float y) {
  return std::isfinite(x) && std::isfinite(y);
}

/// Position at which a spot is drawn: its reference position, else its measured position; none: the
/// spot has neither.
std::optional<Point> position_of(const SpotRow& spot) {
  if (is_finite(spot.ref_x, spot.ref_y)) return Point{spot.ref_x, spot.ref_y};
  if (is_finite(spot.x, spot.y)) return Point{spot.x, spot.y};
  return std::nullopt;
}

Cell sign_of(const SpotRow& spot) {
  if (!is_finite(spot.x, spot.y)) return {U'✕', Style::alarm};
  const float dx = spot.x - spot.ref_x;
  const float dy = spot.y - spot.ref_y;
  if (!is_finite(dx, dy) || std::hypot(dx, dy) <= kMovedPx) return {U'●', Style::positive};
  // y points down, as on the screen.
  constexpr std::array<char32_t, 8> kArrows{U'→', U'↘', U'↓', U'↙', U'←', U'↖', U'↑', U'↗'};
  const int eighth = int(std::lround(std::atan2(dy, dx) / 0.78539816F));
  return {kArrows[std::size_t((eighth + 8) % 8)], Style::negative};
}

/// Maps camera pixels to character cells: isotropic, centred in the rectangle.
class Scale {
 public:
  Scale(const std::vector<SpotRow>& spots, Rect rect) : rect_(rect) {
    float min_x = INFINITY, max_x = -INFINITY, min_y = INFINITY, max_y = -INFINITY;
    for (const SpotRow& spot : spots) {
      const auto place = position_of(spot);
      if (!place) continue;
      min_x = std::min(min_x, place->x);
      max_x = std::max(max_x, place->x);
      min_y = std::min(min_y, place->y);
      max_y = std::max(max_y, place->y);
    }
    middle_ = {(min_x + max_x) / 2, (min_y + max_y) / 2};
    px_ = std::max({double(max_x - min_x) / std::max(rect.width - 2, 1),
                    double(max_y - min_y) / (kCellHeight * std::max(rect.height - 1, 1)), 1e-3});
  }
  int column(float x) const {
    return rect_.x + int(std::lround(double(x - middle_.x) / px_ + 0.5 * (rect_.width - 1)));
  }
  int row(float y) const {
    return rect_.y +
           int(std::lround(double(y - middle_.y) / (kCellHeight * px_) + 0.5 * (rect_.height - 1)));
  }

 private:
  Rect rect_;
  Point middle_;
  double px_ = 1.0;  ///< camera pixels per character width
};

int title(Canvas& canvas, Rect rect) {
  const std::array<std::pair<Cell, const char*>, 3> legend{{{{U'●', Style::positive}, " found "},
                                                            {{U'→', Style::negative}, " >1 px "},
                                                            {{U'✕', Style::alarm}, " lost"}}};
  int x = rect.x + canvas.text(rect.x, rect.y, rect.width, "spots  ", Style::title);
  for (const auto& [cell, word] : legend) {
    canvas.put(x, rect.y, cell.glyph, cell.style);
    x += 1 + canvas.text(x + 1, rect.y, rect.x + rect.width - x - 1, word, Style::dim);
  }
  return rect.y + 1;
}

}  // namespace

void draw_spots(Canvas& canvas, Rect rect, const View& view) {
  const int first = title(canvas, rect);
  const Rect map{rect.x, first, rect.width, rect.height - 1};
  const Scale scale(view.spots, map);
  // Draw lost spots last, so that they stay visible where two spots share a character.
  for (const bool lost : {false, true}) {
    for (const SpotRow& spot : view.spots) {
      const auto place = position_of(spot);
      if (!place || lost == is_finite(spot.x, spot.y)) continue;
      const Cell sign = sign_of(spot);
      canvas.put(scale.column(place->x), scale.row(place->y), sign.glyph, sign.style);
    }
  }
}

}  // namespace ovws::screen
