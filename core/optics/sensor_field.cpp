#include "core/optics/sensor_field.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "core/base/angle.hpp"
#include "core/base/complex_product.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/lenslet_cells.hpp"
#include "core/optics/phasors.hpp"
#include "core/optics/wavefront_rows.hpp"

namespace ovws {
namespace {

constexpr double kMaxLogarithm = 2.0;  // limit of ln(amplitude): polynomials grow outside the pupil

float amplitude(double logarithm) {
  return float(std::exp(std::min(logarithm, kMaxLogarithm)));
}

FarFieldWindow window_in_cells(FarFieldWindow window, double bin_px) {
  window.origin_cpp = bin_px * window.origin_cpp;
  window.step_cpp *= bin_px;
  return window;
}

/// Far-field window along the camera's axes. Shifts the origin, because the base grating's
/// frequency has another direction along these axes.
FarFieldWindow seen_window(const SensorConfig& sensor, const SlmGeometry& slm,
                           const OpticsConfig& optics, int cols, int rows) {
  const PxPerCycle turn = px_per_cycle(optics, slm);
  const Vec2 base_cpp{sensor.grooves[0] / slm.width_px, sensor.grooves[1] / slm.height_px};
  FarFieldWindow window = far_field_window(sensor, slm, optics, cols, rows);
  window.origin_cpp = window.origin_cpp + (turn / turn.scale()) * base_cpp - base_cpp;
  return window;
}

}  // namespace

Result<SensorField> SensorField::make(const SensorConfig& sensor, const SlmGeometry& slm,
                                      const OpticsConfig& optics, int cols, int rows) {
  const FarFieldWindow window = seen_window(sensor, slm, optics, cols, rows);
  if (!sensor.lenslets.empty()) {
    auto lattice = make_lattice(sensor, slm);
    if (!lattice) return fail(lattice.error());
    SensorField field(window, cut_lenslets(sensor, px_per_cycle(optics, slm)));
    field.lenslet_px_ = sensor.lenslets.width_px;
    return field;
  }
  HologramConfig hologram;
  hologram.slm = slm;
  hologram.sensor = sensor;
  const auto renderer = HologramRenderer::make(hologram);
  if (!renderer) return fail(renderer.error());
  Image<std::uint8_t> grey;
  renderer->render(HologramKind::sensor, {}, grey);
  return SensorField(window, cut_pupil(renderer->lattice(), sensor.pupil_diameter_px,
                                       px_per_cycle(optics, slm), window, grey));
}

SensorField::SensorField(FarFieldWindow window, PupilCells cells)
    : window_(window),
      cells_(std::move(cells)),
      outside_lit_(!cells_.outside.pixels.empty()),
      phasors_(cells_.grid.width, cells_.grid.height),
      pupil_(cells_.light.size()) {
  if (!outside_lit_) return;
  sums_ = Image<std::complex<float>>(cells_.grid.width, cells_.grid.height);
  far_field_.emplace(SlmGeometry{cells_.grid.width, cells_.grid.height},
                     window_in_cells(window, cells_.grid.bin_px));
}

void SensorField::propagate(std::span<const Mode> modes, const Light& light) {
  set_phasors(modes);
  std::fill(sums_.pixels.begin(), sums_.pixels.end(), 0.0F);
  for (const CellRun& run : cells_.runs) {
    if (outside_lit_ || run.piece < cells_.subapertures) add_run(run, light);
  }
  if (!far_field_) return propagate_lenslets();
  far_field_->propagate(sums_, far_);
  if (!outside_lit_) return;
  const Image<std::complex<float>>& fixed = far_outside_pupil(light.ln_amplitude);
  std::transform(far_.pixels.begin(), far_.pixels.end(), fixed.pixels.begin(), far_.pixels.begin(),
                 std::plus<>());
}

/// Sums the far fields of the lenslets, each in a box of pixels around its centre.
void SensorField::propagate_lenslets() {
  if (far_.width != window_.cols || far_.height != window_.rows) {
    far_ = Image<std::complex<float>>(window_.cols, window_.rows);
  }
  std::fill(far_.pixels.begin(), far_.pixels.end(), 0.0F);
  for (auto run = cells_.runs.begin(); run != cells_.runs.end();) {
    const auto end = std::find_if(run, cells_.runs.end(),
                                  [&](const CellRun& r) { return r.piece != run->piece; });
    add_lenslet(cells_, lenslet_px_, {run, end}, pupil_, window_, far_);
    run = end;
  }
}

void SensorField::set_phasors(std::span<const Mode> modes) {
  const CellGrid& grid = cells_.grid;
  const double diameter = 2.0 * cells_.pupil_radius_px / grid.bin_px;
  const WavefrontRows added(modes, grid.middle(), diameter, cells_.turn);
  const std::vector<std::complex<float>>& table = unit_phasors();
  std::vector<double> values(std::size_t(grid.width));
  for (int y = 0; y < grid.height; ++y) {
    added.waves(y, 0, values);
    std::transform(values.begin(), values.end(), phasors_.row(y),
                   [&](double waves) { return table[phase16(waves)]; });
  }
}

void SensorField::add_run(const CellRun& run, const Light& light) {
  const auto piece = std::size_t(run.piece);
  const bool own = run.piece < cells_.subapertures;
  std::complex<float> factor = 1.0F, next = 1.0F;
  if (own && !light.slopes_cpp.empty()) {
    const Vec2 slope = light.slopes_cpp[piece];
    const Vec2 off = cells_.grid.at_px(run.begin, run.y) - cells_.pieces[piece].centre_px;
    const auto phasor = [](double waves) { return std::complex<float>(unit_phasor(waves)); };
    factor = phasor(slope.x * off.x + slope.y * off.y);
    next = phasor(slope.x * cells_.grid.bin_px);
  }
  if (!own && !light.ln_amplitude.empty()) {
    const Vec2 middle = cells_.grid.at_px(0.5 * (run.begin + run.end - 1), run.y);
    double ln = 0.0;
    for (const Mode& mode : light.ln_amplitude) {
      ln += mode.waves * zernike(mode.j, cells_.in_pupil(middle));
    }
    factor *= amplitude(ln);
  }
  const std::complex<float>* const phasors = phasors_.row(run.y);
  const std::complex<float>* from = cells_.light.data() + run.first;
  std::complex<float>* to = pupil_.data() + run.first;
  for (int x = run.begin; x < run.end; ++x, factor = product(factor, next)) {
    *to++ = product(product(*from++, phasors[x]), factor);
  }
  if (own && !light.fields.empty()) multiply(run, light.fields[piece]);
  if (!far_field_) return;
  std::complex<float>* const sums = sums_.row(run.y);
  const std::complex<float>* sum = pupil_.data() + run.first;
  for (int x = run.begin; x < run.end; ++x) sums[x] += *sum++;
}

/// Multiplies the field in the cells of a run by 1 + the polynomial `field`.
void SensorField::multiply(const CellRun& run, const LocalField& field) {
  const PupilPiece& piece = cells_.pieces[std::size_t(run.piece)];
  const Vec2 first =
      (1.0 / piece.radius_px) * (cells_.grid.at_px(run.begin, run.y) - piece.centre_px);
  const double step = cells_.grid.bin_px / piece.radius_px, eta = first.y;
  std::array<std::complex<double>, 4> along{};  // coefficients of the powers of xi at this eta
  std::size_t k = 0;
  for (std::size_t a = 0; a < along.size(); ++a) {
    double power = 1.0;
    for (std::size_t b = 0; a + b < along.size(); ++b, power *= eta) along[a] += power * field[k++];
  }
  along[0] += 1.0;
  std::complex<float>* to = pupil_.data() + run.first;
  for (int x = 0; x < run.end - run.begin; ++x) {
    const double xi = first.x + x * step;
    const std::complex<double> value = ((along[3] * xi + along[2]) * xi + along[1]) * xi + along[0];
    to[x] = product(to[x], std::complex<float>(value));
  }
}

const Image<std::complex<float>>& SensorField::far_outside_pupil(
    std::span<const Mode> ln_amplitude) {
  if (fixed_ln_amplitude_ && std::ranges::equal(*fixed_ln_amplitude_, ln_amplitude)) return fixed_;
  const CellGrid& grid = cells_.outside_grid;
  Image<std::complex<float>> light = cells_.outside;
  if (!ln_amplitude.empty()) {
    const WavefrontRows logarithm(ln_amplitude, grid.middle(),
                                  2.0 * cells_.pupil_radius_px / grid.bin_px, cells_.turn);
    std::vector<double> values(std::size_t(light.width));
    for (int y = 0; y < light.height; ++y) {
      logarithm.waves(y, 0, values);
      for (int x = 0; x < light.width; ++x) light.at(x, y) *= amplitude(values[std::size_t(x)]);
    }
  }
  FarField({grid.width, grid.height}, window_in_cells(window_, grid.bin_px))
      .propagate(light, fixed_);
  fixed_ln_amplitude_.emplace(ln_amplitude.begin(), ln_amplitude.end());
  return fixed_;
}

}  // namespace ovws
