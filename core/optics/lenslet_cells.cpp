#include "core/optics/lenslet_cells.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/angle.hpp"
#include "core/optics/complex_matrices.hpp"
#include "core/optics/phasors.hpp"

namespace ovws {
namespace {

constexpr int kParts = 2;              // parts along the side of a cell, for its covered share
constexpr double kReachPitches = 4.5;  // of a lenslet's far field

std::complex<float> phasor(double waves) {
  return unit_phasors()[phase16(waves)];
}

bool covers(LensletShape shape, double half_px, Vec2 at) {
  const Vec2 a{std::abs(at.x), std::abs(at.y)};
  switch (shape) {
    case LensletShape::square:
      return a.x <= half_px && a.y <= half_px;
    case LensletShape::hexagon:  // with neighbours along +-x
      return a.x <= half_px && 0.5 * a.x + std::sqrt(0.75) * a.y <= half_px;
    case LensletShape::circle:
      break;
  }
  return norm(at) <= half_px;
}

/// Phase of the spiral plate, waves.
double plate_waves(const SpiralPlate& plate, int charge, Vec2 at) {
  if (charge == 0) return 0.0;
  const Vec2 from_axis = at - plate.shift_px;
  double turns = std::atan2(from_axis.y, from_axis.x) / kTwoPi;
  turns -= std::floor(turns);
  if (plate.levels > 0) turns = std::floor(turns * plate.levels) / plate.levels;
  return charge * plate.depth * turns;
}

/// Mean field of a cell of one lenslet. `at`: the cell's centre from the lenslet's, along the
/// camera's axes.
std::complex<float> cell_field(const SensorConfig& sensor, const PupilCells& cells, Vec2 at) {
  const Lenslets& lenslets = sensor.lenslets;
  const double bin_px = cells.grid.bin_px;
  const double turn = lenslets.rotation_deg * std::numbers::pi / 180.0;
  const Vec2 along{std::cos(turn), std::sin(turn)};
  std::complex<float> sum = 0.0F;
  for (int k = 0; k < kParts * kParts; ++k) {
    const Vec2 part = cells.turn.back({at.x + bin_px * ((k % kParts + 0.5) / kParts - 0.5),
                                       at.y + bin_px * ((k / kParts + 0.5) / kParts - 0.5)});
    const Vec2 on_lenslet{along.x * part.x + along.y * part.y, along.x * part.y - along.y * part.x};
    if (!covers(lenslets.shape, 0.5 * lenslets.width_px, on_lenslet)) continue;
    sum += phasor(plate_waves(lenslets.plate, sensor.charge, on_lenslet));
  }
  return sum / float(kParts * kParts);
}

/// Appends the runs of a lenslet: in each row of cells, from the first covered cell to the last.
void append_lenslet(const SensorConfig& sensor, int piece, PupilCells& cells) {
  const PupilPiece& own = cells.pieces[std::size_t(piece)];
  const double half_cells = own.radius_px / cells.grid.bin_px + 1.0;
  const Vec2 middle = cells.grid.at_cell(own.centre_px);
  for (int y = int(middle.y - half_cells); y <= int(middle.y + half_cells) + 1; ++y) {
    CellRun run{piece, y, 0, 0, cells.light.size()};
    for (int x = int(middle.x - half_cells); x <= int(middle.x + half_cells) + 1; ++x) {
      const Vec2 place = cells.grid.at_px(x, y);
      const std::complex<float> field = cell_field(sensor, cells, place - own.centre_px);
      if (field == 0.0F && run.begin == run.end) continue;  // not begun
      if (run.begin == run.end) run.begin = run.end = x;
      const Vec2 from_half = place - 0.5 * own.centre_px;
      const double cycles = own.grating_cpp.x * from_half.x + own.grating_cpp.y * from_half.y;
      cells.light.push_back(field * phasor(cycles));
      ++run.end;
    }
    if (run.end > run.begin) cells.runs.push_back(run);
  }
}

/// Integral of exp(-2 pi i f_k x) over each cell, per width: rows k for pixels, columns p for
/// cells. f_k: frequency of a pixel without the lenslet's grating.
Eigen::MatrixXcf kernel(double first_cpp, double step_cpp, int pixels, double first_px,
                        double cell_px, int cells) {
  Eigen::MatrixXcf out(pixels, cells);
  for (int p = 0; p < cells; ++p) {
    const double place = first_px + cell_px * p;
    std::complex<double> value = unit_phasor(-first_cpp * place);
    const std::complex<double> next = unit_phasor(-step_cpp * place);
    for (int k = 0; k < pixels; ++k, value *= next) out(k, p) = std::complex<float>(value);
  }
  for (int k = 0; k < pixels; ++k) {
    const double x = std::numbers::pi * (first_cpp + k * step_cpp) * cell_px;
    if (std::abs(x) > 1e-9) out.row(k) *= float(std::sin(x) / x);
  }
  return out;
}

}  // namespace

PupilCells cut_lenslets(const SensorConfig& sensor, const PxPerCycle& turn) {
  const Lenslets& lenslets = sensor.lenslets;
  PupilCells cells;
  const double bin_px = lenslets.width_px / kLensletCells;
  cells.turn = turn.scaled_to(1.0);
  cells.pupil_radius_px = 0.5 * sensor.pupil_diameter_px;
  double most_px = cells.pupil_radius_px;
  for (const Vec2 centre : lenslets.centres_px) most_px = std::max(most_px, norm(centre));
  const int half = int(std::ceil((most_px + lenslets.width_px) / bin_px)) + 2;
  cells.grid = {bin_px, 2 * half, 2 * half};
  const double radius_px =
      lenslets.width_px * (lenslets.shape == LensletShape::circle   ? 0.5
                           : lenslets.shape == LensletShape::square ? std::sqrt(0.5)
                                                                    : std::sqrt(1.0 / 3.0));
  for (const Vec2 centre : lenslets.centres_px) {
    const Vec2 seen = cells.turn.seen(centre);
    cells.pieces.push_back({seen, radius_px, (1.0 / lenslets.px_per_cycle) * seen});
  }
  cells.subapertures = int(cells.pieces.size());
  for (int piece = 0; piece < cells.subapertures; ++piece) append_lenslet(sensor, piece, cells);
  return cells;
}

void add_lenslet(const PupilCells& cells, double width_px, std::span<const CellRun> runs,
                 std::span<const std::complex<float>> pupil, const FarFieldWindow& window,
                 Image<std::complex<float>>& far) {
  if (runs.empty()) return;
  const PupilPiece& piece = cells.pieces[std::size_t(runs.front().piece)];
  int left = runs.front().begin, right = runs.front().end;
  for (const CellRun& run : runs) {
    left = std::min(left, run.begin);
    right = std::max(right, run.end);
  }
  const int top = runs.front().y, height = runs.back().y + 1 - top;
  Eigen::MatrixXcf field = Eigen::MatrixXcf::Zero(height, right - left);
  const Vec2 first_px = cells.grid.at_px(left, top);
  const double bin_px = cells.grid.bin_px;
  for (const CellRun& run : runs) {
    for (int x = run.begin; x < run.end; ++x) {
      const Vec2 at = cells.grid.at_px(x, run.y);
      const double cycles = piece.grating_cpp.x * at.x + piece.grating_cpp.y * at.y;
      field(run.y - top, x - left) =
          pupil[run.first + std::size_t(x - run.begin)] * phasor(-cycles);
    }
  }
  const Vec2 spot = (1.0 / window.step_cpp) * (piece.grating_cpp - window.origin_cpp);
  const double reach_px = kReachPitches * width_px;
  const int x0 = std::max(0, int(std::ceil(spot.x - reach_px)));
  const int y0 = std::max(0, int(std::ceil(spot.y - reach_px)));
  const int x1 = std::min(far.width, int(spot.x + reach_px) + 1);
  const int y1 = std::min(far.height, int(spot.y + reach_px) + 1);
  if (x1 - x0 < kMinProductRows || y1 - y0 < kMinProductRows) return;
  const Vec2 from_cpp =
      window.origin_cpp + window.step_cpp * Vec2{double(x0), double(y0)} - piece.grating_cpp;
  const Eigen::MatrixXcf along_x =
      kernel(from_cpp.x, window.step_cpp, x1 - x0, first_px.x, bin_px, right - left);
  const Eigen::MatrixXcf along_y =
      kernel(from_cpp.y, window.step_cpp, y1 - y0, first_px.y, bin_px, height);
  Eigen::MatrixXcf half(x1 - x0, height), box(x1 - x0, y1 - y0);
  multiply_by_transposed(along_x, field, half);
  multiply_by_transposed(half, along_y, box);
  for (int y = y0; y < y1; ++y) {
    std::complex<float>* const row = far.row(y) + x0;
    for (int x = 0; x < x1 - x0; ++x) row[x] += box(x, y - y0);
  }
}

}  // namespace ovws
