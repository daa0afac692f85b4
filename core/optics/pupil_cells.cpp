#include "core/optics/pupil_cells.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/base/angle.hpp"
#include "core/optics/circle_columns.hpp"
#include "core/optics/phasors.hpp"

namespace ovws {
namespace {

constexpr int kTilePx = 64;     // side of the square tiles outside the subapertures
constexpr int kMinAcross = 64;  // minimum number of cells across a subaperture
constexpr int kMaxBinPx = 4;
constexpr double kMaxBand = 0.6;  // maximum window width, cycles per cell
constexpr double kTie = 1e-6;     // in cells; pixels of an SLM of odd size lie between two cells
constexpr int kOutside = -2;      // pixel outside the pupil, where no mode is applied
constexpr int kUnowned = -1;      // pixel in the pupil, but in no subaperture

void assign_owner(Image<int>& owner, Vec2 centre_px, double diameter_px, int to) {
  for (int y = 0; y < owner.height; ++y) {
    const Columns in = columns_in_circle(centre_px, diameter_px, y, owner.width);
    std::fill_n(owner.row(y) + in.begin, in.end - in.begin, to);
  }
}

int bin_for(const FarFieldWindow& window, double diameter_px) {
  const double band_cpp = window.step_cpp * std::max(window.cols, window.rows);
  const int most = int(std::min(diameter_px / kMinAcross, kMaxBand / band_cpp));
  return std::clamp(most, 1, kMaxBinPx);
}

/// Carrier frequency of light outside the subapertures along one axis: 0 (the zeroth order) if the
/// window contains it, otherwise the frequency at the window's middle.
double carrier(double origin_cpp, double step_cpp, int count) {
  const double last_cpp = origin_cpp + step_cpp * (count - 1);
  return origin_cpp <= 0.0 && last_cpp >= 0.0 ? 0.0 : 0.5 * (origin_cpp + last_cpp);
}

/// Cell grid along the camera's axes over a box on the SLM of half width and height half_px, or
/// over its inscribed ellipse if `round`.
CellGrid grid_over(Vec2 half_px, bool round, const PxPerCycle& turn, double bin_px) {
  const Vec2 x = turn.seen({half_px.x, 0.0}), y = turn.seen({0.0, half_px.y});
  const auto half = [&](double by_x, double by_y) {
    const double extent = round ? std::hypot(by_x, by_y) : std::abs(by_x) + std::abs(by_y);
    return int(std::ceil(extent / bin_px - 1e-6));
  };
  return {bin_px, 2 * half(x.x, y.x), 2 * half(x.y, y.y)};
}

/// Largest scale of `turn` in any direction, divided by its mean scale. 1 if x and y scale equally.
double stretch(const PxPerCycle& turn) {
  const PxPerCycle t = turn / turn.scale();
  const double squares = t.xx * t.xx + t.xy * t.xy + t.yx * t.yx + t.yy * t.yy;
  return std::sqrt(0.5 * (squares + std::sqrt(std::max(0.0, squares * squares - 4.0))));
}

/// Piece number of every SLM pixel, or kOutside. Also appends the pieces to `cells`.
Image<int> owners(const Lattice& lattice, int width, int height, PupilCells& cells) {
  const Vec2 centre_px{0.5 * (width - 1), 0.5 * (height - 1)};
  const PxPerCycle direction = cells.turn / cells.turn.scale();
  const double by = stretch(cells.turn);
  Image<int> owner(width, height, kOutside);
  assign_owner(owner, centre_px, 2.0 * cells.pupil_radius_px, kUnowned);
  for (const Subaperture& s : lattice.subapertures) {
    assign_owner(owner, centre_px + s.centre_px, lattice.diameter_px, cells.subapertures++);
    cells.pieces.push_back({cells.turn.seen(s.centre_px), 0.5 * by * lattice.diameter_px,
                            direction * s.frequency_cpp});
  }
  const int across = (width + kTilePx - 1) / kTilePx, down = (height + kTilePx - 1) / kTilePx;
  for (int k = 0; k < across * down; ++k) {
    const double half = 0.5 * (kTilePx - 1);
    const Vec2 middle{k % across * kTilePx + half, k / across * kTilePx + half};
    cells.pieces.push_back({cells.turn.seen(middle - centre_px), by * std::sqrt(2.0) * half, {}});
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      int& piece = owner.at(x, y);
      if (piece == kUnowned) piece = cells.subapertures + y / kTilePx * across + x / kTilePx;
    }
  }
  return owner;
}

/// Rectangle of cells around one piece of the pupil, with a margin. Columns `left` to `right` and
/// rows `top` to `bottom` are all included.
struct PieceBox {
  int left = 0, right = -1, top = 0, bottom = -1;
  Image<std::complex<double>> sums;
};

PieceBox box_of(const CellGrid& grid, const PupilPiece& piece) {
  const Vec2 reach{piece.radius_px + 2.0 * grid.bin_px, piece.radius_px + 2.0 * grid.bin_px};
  const Vec2 first = grid.at_cell(piece.centre_px - reach);
  const Vec2 last = grid.at_cell(piece.centre_px + reach);
  PieceBox box;
  box.left = std::clamp(int(std::floor(first.x)), 0, grid.width - 1);
  box.top = std::clamp(int(std::floor(first.y)), 0, grid.height - 1);
  box.right = std::clamp(int(std::ceil(last.x)), 0, grid.width - 1);
  box.bottom = std::clamp(int(std::ceil(last.y)), 0, grid.height - 1);
  box.sums = Image<std::complex<double>>(box.right - box.left + 1, box.bottom - box.top + 1);
  return box;
}

void add_to(int x, int y, std::complex<double> value, Vec2 at_px, Vec2 carrier_cpp,
            const CellGrid& grid, PieceBox& box) {
  const Vec2 off = at_px - grid.at_px(x, y);
  const double cycles = carrier_cpp.x * off.x + carrier_cpp.y * off.y;
  box.sums.at(x - box.left, y - box.top) += value * unit_phasor(-cycles);
}

/// Adds a pixel's field to the cell that contains the pixel. For a rotated camera, shares the field
/// among the four nearest cells with bilinear weights: with unequal numbers of pixels per cell, the
/// model would show stray light.
void add_pixel(std::complex<double> value, Vec2 at_px, Vec2 carrier_cpp, const CellGrid& grid,
               bool turned, PieceBox& box) {
  const Vec2 cell = grid.at_cell(at_px);
  const auto inside = [](int at, int size) { return std::clamp(at, 0, size - 1); };
  if (!turned) {
    const auto nearest = [](double at) { return int(std::floor(at + 0.5 + kTie)); };
    return add_to(inside(nearest(cell.x), grid.width), inside(nearest(cell.y), grid.height), value,
                  at_px, carrier_cpp, grid, box);
  }
  const double left = std::floor(cell.x), top = std::floor(cell.y);
  for (int k = 0; k < 4; ++k) {
    const bool right = k % 2 == 1, below = k / 2 == 1;
    const double weight =
        (right ? cell.x - left : 1.0 - cell.x + left) * (below ? cell.y - top : 1.0 - cell.y + top);
    add_to(inside(int(left) + right, grid.width), inside(int(top) + below, grid.height),
           weight * value, at_px, carrier_cpp, grid, box);
  }
}

/// Appends the runs of a piece: in each row of cells, from the first cell with light to the last.
void append_piece(PupilCells& cells, int piece, const PieceBox& box) {
  const auto is_lit = [](const std::complex<double>& sum) { return sum != 0.0; };
  for (int y = 0; y < box.sums.height; ++y) {
    const std::complex<double>* const row = box.sums.row(y);
    const std::complex<double>* const end = row + box.sums.width;
    const auto* const first = std::find_if(row, end, is_lit);
    if (first == end) continue;
    const auto* last = end;
    while (!is_lit(*(last - 1))) --last;
    cells.runs.push_back({piece, box.top + y, box.left + int(first - row),
                          box.left + int(last - row), cells.light.size()});
    std::transform(first, last, std::back_inserter(cells.light),
                   [](const auto& sum) { return std::complex<float>(sum); });
  }
}

}  // namespace

PupilCells cut_pupil(const Lattice& lattice, double pupil_diameter_px, const PxPerCycle& turn,
                     const FarFieldWindow& window, const Image<std::uint8_t>& grey) {
  PupilCells cells;
  const int bin_px = bin_for(window, lattice.diameter_px);
  const double radius_px = 0.5 * pupil_diameter_px;
  cells.turn = turn;
  cells.pupil_radius_px = radius_px;
  cells.grid = grid_over({radius_px, radius_px}, true, turn, bin_px);
  cells.outside_grid = grid_over({0.5 * grey.width, 0.5 * grey.height}, false, turn, bin_px);
  const Image<int> owner = owners(lattice, grey.width, grey.height, cells);
  const bool turned = turn != PxPerCycle(turn.scale());
  const Vec2 stray_cpp{carrier(window.origin_cpp.x, window.step_cpp, window.cols),
                       carrier(window.origin_cpp.y, window.step_cpp, window.rows)};
  std::vector<PieceBox> boxes;
  for (const PupilPiece& piece : cells.pieces) boxes.push_back(box_of(cells.grid, piece));
  PieceBox outside{.sums = {cells.outside_grid.width, cells.outside_grid.height}};
  const Vec2 centre_px{0.5 * (grey.width - 1), 0.5 * (grey.height - 1)};
  for (int y = 0; y < grey.height; ++y) {
    for (int x = 0; x < grey.width; ++x) {
      const Vec2 at = turn.seen(Vec2{double(x), double(y)} - centre_px);
      const int piece = owner.at(x, y);
      const bool own = piece >= 0 && piece < cells.subapertures;
      add_pixel(unit_phasors()[std::size_t(grey.at(x, y)) << 8], at,
                own ? cells.pieces[std::size_t(piece)].grating_cpp : stray_cpp,
                piece == kOutside ? cells.outside_grid : cells.grid, turned,
                piece == kOutside ? outside : boxes[std::size_t(piece)]);
    }
  }
  for (std::size_t k = 0; k < boxes.size(); ++k) append_piece(cells, int(k), boxes[k]);
  cells.outside = Image<std::complex<float>>(outside.sums.width, outside.sums.height);
  std::transform(outside.sums.pixels.begin(), outside.sums.pixels.end(),
                 cells.outside.pixels.begin(),
                 [](const auto& sum) { return std::complex<float>(sum); });
  return cells;
}

}  // namespace ovws
