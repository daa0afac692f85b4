#include "core/optics/sensor_field.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/complex_product.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/phase_rows.hpp"
#include "core/optics/wavefront_rows.hpp"

namespace ovws {
namespace {

constexpr double kMaxLogarithm = 2.0;  // of amplitudes: polynomials grow outside the pupil

float amplitude(double logarithm) {
  return float(std::exp(std::min(logarithm, kMaxLogarithm)));
}

ChirpZ::Axis axis(int inputs, int outputs, double centre, double first_cpp, double step_cpp,
                  int bin_px) {
  return {inputs, outputs, centre, bin_px * first_cpp, bin_px * step_cpp};
}

}  // namespace

Result<SensorField> SensorField::make(const SensorConfig& sensor, const SlmGeometry& slm,
                                      const OpticsConfig& optics, int cols, int rows) {
  if (auto ok = check_straight(optics, slm); !ok) return fail(ok.error());
  HologramConfig hologram;
  hologram.slm = slm;
  hologram.sensor = sensor;
  const auto renderer = HologramRenderer::make(hologram);
  if (!renderer) return fail(renderer.error());
  Image<std::uint8_t> grey;
  renderer->render(HologramKind::sensor, {}, grey);
  const FarFieldWindow window = far_field_window(sensor, slm, optics, cols, rows);
  return SensorField(slm, window,
                     cut_pupil(renderer->lattice(), sensor.pupil_diameter_px, window, grey));
}

SensorField::SensorField(SlmGeometry slm, FarFieldWindow window, PupilCells cells)
    : slm_(slm),
      window_(window),
      cells_(std::move(cells)),
      along_x_(axis(cells_.width, window.cols, cells_.at_cell(cells_.pupil_centre_px).x,
                    window.origin_cpp.x, window.step_cpp, cells_.bin_px)),
      along_y_(axis(cells_.height, window.rows, cells_.at_cell(cells_.pupil_centre_px).y,
                    window.origin_cpp.y, window.step_cpp, cells_.bin_px)),
      phasors_(cells_.width, cells_.height),
      pupil_(cells_.light.size()),
      sums_(cells_.width, cells_.height),
      columns_(cells_.height, window.cols),
      far_(window.cols, window.rows) {}

void SensorField::propagate(std::span<const Mode> modes, const Light& light) {
  set_phasors(modes, light.ln_amplitude);
  std::fill(sums_.pixels.begin(), sums_.pixels.end(), 0.0F);
  for (const CellRun& run : cells_.runs) {
    if (outside_lit_ || run.piece < cells_.subapertures) add_run(run, light);
  }
  along_x_.transform(sums_.pixels.data(), sums_.height, columns_.pixels.data());
  along_y_.transform(columns_.pixels.data(), far_.width, far_.pixels.data());
  if (!outside_lit_) return;
  const Image<std::complex<float>>& fixed = far_outside_pupil(light.ln_amplitude);
  std::transform(far_.pixels.begin(), far_.pixels.end(), fixed.pixels.begin(), far_.pixels.begin(),
                 std::plus<>());
}

void SensorField::set_phasors(std::span<const Mode> modes, std::span<const Mode> ln_amplitude) {
  const Vec2 centre = cells_.at_cell(cells_.pupil_centre_px);
  const double diameter = 2.0 * cells_.pupil_radius_px / cells_.bin_px;
  const WavefrontRows added(modes, centre, diameter), logarithm(ln_amplitude, centre, diameter);
  const std::vector<std::complex<float>>& table = unit_phasors();
  std::vector<double> values(std::size_t(cells_.width));
  for (int y = 0; y < cells_.height; ++y) {
    std::complex<float>* const row = phasors_.row(y);
    added.waves(y, 0, values);
    std::transform(values.begin(), values.end(), row,
                   [&](double waves) { return table[phase16(waves)]; });
    if (ln_amplitude.empty()) continue;
    logarithm.waves(y, 0, values);
    std::transform(values.begin(), values.end(), row, row,
                   [](double ln, std::complex<float> value) { return amplitude(ln) * value; });
  }
}

void SensorField::add_run(const CellRun& run, const Light& light) {
  const auto piece = std::size_t(run.piece);
  const bool own = run.piece < cells_.subapertures;
  std::complex<float> factor = 1.0F, next = 1.0F;
  if (own && !light.slopes_cpp.empty()) {
    const Vec2 slope = light.slopes_cpp[piece];
    const Vec2 off =
        cells_.at_px(run.begin, run.y) - cells_.pupil_centre_px - cells_.pieces[piece].centre_px;
    const auto phasor = [](double waves) {
      return std::complex<float>(std::polar(1.0, 2.0 * std::numbers::pi * waves));
    };
    factor = phasor(slope.x * off.x + slope.y * off.y);
    next = phasor(slope.x * cells_.bin_px);
  }
  if (own && !light.amplitudes.empty()) factor *= float(light.amplitudes[piece]);
  const std::complex<float>* const phasors = phasors_.row(run.y);
  std::complex<float>* const sums = sums_.row(run.y);
  const std::complex<float>* from = cells_.light.data() + run.first;
  std::complex<float>* to = pupil_.data() + run.first;
  for (int x = run.begin; x < run.end; ++x, factor = product(factor, next)) {
    *to = product(product(*from++, phasors[x]), factor);
    sums[x] += *to++;
  }
}

const Image<std::complex<float>>& SensorField::far_outside_pupil(
    std::span<const Mode> ln_amplitude) {
  if (fixed_ln_amplitude_ && std::ranges::equal(*fixed_ln_amplitude_, ln_amplitude)) return fixed_;
  Image<std::complex<float>> light = cells_.outside_pupil;
  if (!ln_amplitude.empty()) {
    const WavefrontRows logarithm(ln_amplitude, cells_.pupil_centre_px,
                                  2.0 * cells_.pupil_radius_px);
    std::vector<double> values(std::size_t(light.width));
    for (int y = 0; y < light.height; ++y) {
      logarithm.waves(y, 0, values);
      for (int x = 0; x < light.width; ++x) light.at(x, y) *= amplitude(values[std::size_t(x)]);
    }
  }
  FarField(slm_, window_).propagate(light, fixed_);
  fixed_ln_amplitude_.emplace(ln_amplitude.begin(), ln_amplitude.end());
  return fixed_;
}

}  // namespace ovws
