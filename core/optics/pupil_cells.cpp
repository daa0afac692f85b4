#include "core/optics/pupil_cells.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/optics/circle_columns.hpp"

namespace ovws {
namespace {

constexpr int kTilePx = 64;     // side of the pieces outside the subapertures
constexpr int kMinAcross = 64;  // cells in the diameter of a subaperture
constexpr int kMaxBinPx = 4;
constexpr double kMaxBand = 0.6;  // of the frequencies that the cells tell apart
constexpr int kOutside = -2;      // outside the pupil: modes are not applied
constexpr int kUnowned = -1;      // in the pupil, outside the subapertures

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

/// 0 if the window shows it, else the window's middle.
double carrier(double origin_cpp, double step_cpp, int count) {
  const double last_cpp = origin_cpp + step_cpp * (count - 1);
  return origin_cpp <= 0.0 && last_cpp >= 0.0 ? 0.0 : 0.5 * (origin_cpp + last_cpp);
}

/// The piece of every pixel, or kOutside. Appends the pieces.
Image<int> owners(const Lattice& lattice, int width, int height, PupilCells& cells) {
  cells.subapertures = int(lattice.subapertures.size());
  for (const Subaperture& s : lattice.subapertures) {
    cells.pieces.push_back({s.centre_px, 0.5 * lattice.diameter_px, s.frequency_cpp});
  }
  const int across = (width + kTilePx - 1) / kTilePx, down = (height + kTilePx - 1) / kTilePx;
  for (int k = 0; k < across * down; ++k) {
    const double half = 0.5 * (kTilePx - 1);
    const Vec2 middle{k % across * kTilePx + half, k / across * kTilePx + half};
    cells.pieces.push_back({middle - cells.pupil_centre_px, std::sqrt(2.0) * half, {}});
  }
  Image<int> owner(width, height, kOutside);
  assign_owner(owner, cells.pupil_centre_px, 2.0 * cells.pupil_radius_px, kUnowned);
  for (int i = 0; i < cells.subapertures; ++i) {
    const PupilPiece& piece = cells.pieces[std::size_t(i)];
    assign_owner(owner, cells.pupil_centre_px + piece.centre_px, 2.0 * piece.radius_px, i);
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      int& piece = owner.at(x, y);
      if (piece == kUnowned) piece = cells.subapertures + y / kTilePx * across + x / kTilePx;
    }
  }
  return owner;
}

/// The cells of one piece, as a dense box.
struct PieceBox {
  int left = 0, right = -1, top = 0, bottom = -1;
  Image<std::complex<double>> sums;
};

PieceBox box_of(const PupilCells& cells, const PupilPiece& piece) {
  const Vec2 middle = cells.pupil_centre_px + piece.centre_px;
  const Vec2 first = cells.at_cell(middle - Vec2{piece.radius_px, piece.radius_px});
  const Vec2 last = cells.at_cell(middle + Vec2{piece.radius_px, piece.radius_px});
  PieceBox box;
  box.left = std::clamp(int(std::floor(first.x)), 0, cells.width - 1);
  box.top = std::clamp(int(std::floor(first.y)), 0, cells.height - 1);
  box.right = std::clamp(int(std::ceil(last.x)), 0, cells.width - 1);
  box.bottom = std::clamp(int(std::ceil(last.y)), 0, cells.height - 1);
  box.sums = Image<std::complex<double>>(box.right - box.left + 1, box.bottom - box.top + 1);
  return box;
}

/// Appends the runs of a piece, from its first cell with light to its last in each row.
void append(PupilCells& cells, int piece, const PieceBox& box) {
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

const std::vector<std::complex<float>>& unit_phasors() {
  static const auto table = [] {
    std::vector<std::complex<float>> made(65536);
    for (std::size_t k = 0; k < made.size(); ++k) {
      made[k] = std::complex<float>(std::polar(1.0, 2.0 * std::numbers::pi * double(k) / 65536.0));
    }
    return made;
  }();
  return table;
}

PupilCells cut_pupil(const Lattice& lattice, double pupil_diameter_px, const FarFieldWindow& window,
                     const Image<std::uint8_t>& grey) {
  PupilCells cells;
  cells.bin_px = bin_for(window, lattice.diameter_px);
  cells.pupil_centre_px = {0.5 * (grey.width - 1), 0.5 * (grey.height - 1)};
  cells.pupil_radius_px = 0.5 * pupil_diameter_px;
  const auto first = [&](double centre_px) {
    return std::max(0, int(std::floor(centre_px - cells.pupil_radius_px)));
  };
  const auto across = [&](int size, int first_px) {
    const int last_px = std::min(size, size - first_px);  // the pupil is centred on the SLM
    return (last_px - first_px + cells.bin_px - 1) / cells.bin_px;
  };
  cells.first_x_px = first(cells.pupil_centre_px.x);
  cells.first_y_px = first(cells.pupil_centre_px.y);
  cells.width = across(grey.width, cells.first_x_px);
  cells.height = across(grey.height, cells.first_y_px);
  const Image<int> owner = owners(lattice, grey.width, grey.height, cells);
  const Vec2 stray_cpp{carrier(window.origin_cpp.x, window.step_cpp, window.cols),
                       carrier(window.origin_cpp.y, window.step_cpp, window.rows)};
  std::vector<PieceBox> boxes;
  for (const PupilPiece& piece : cells.pieces) boxes.push_back(box_of(cells, piece));
  cells.outside_pupil = Image<std::complex<float>>(grey.width, grey.height);
  for (int y = 0; y < grey.height; ++y) {
    for (int x = 0; x < grey.width; ++x) {
      const std::complex<float> value = unit_phasors()[std::size_t(grey.at(x, y)) << 8];
      const int piece = owner.at(x, y);
      if (piece == kOutside) {
        cells.outside_pupil.at(x, y) = value;
        continue;
      }
      const int cx = (x - cells.first_x_px) / cells.bin_px;
      const int cy = (y - cells.first_y_px) / cells.bin_px;
      const Vec2 off = Vec2{double(x), double(y)} - cells.at_px(cx, cy);
      const Vec2 f =
          piece < cells.subapertures ? cells.pieces[std::size_t(piece)].grating_cpp : stray_cpp;
      PieceBox& box = boxes[std::size_t(piece)];
      box.sums.at(cx - box.left, cy - box.top) +=
          std::complex<double>(value) *
          std::polar(1.0, -2.0 * std::numbers::pi * (f.x * off.x + f.y * off.y));
    }
  }
  for (std::size_t k = 0; k < boxes.size(); ++k) append(cells, int(k), boxes[k]);
  return cells;
}

}  // namespace ovws
