#include "core/optics/hologram.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/number_text.hpp"
#include "core/optics/circle_columns.hpp"
#include "core/optics/hologram_row.hpp"
#include "core/optics/phasors.hpp"
#include "core/optics/wavefront_rows.hpp"

namespace ovws {
namespace {

constexpr double kMaxWaves = 1e6;  ///< larger coefficients are mistakes and lose phase precision

Vec2 pupil_centre(const SlmGeometry& slm) {
  return {0.5 * (slm.width_px - 1), 0.5 * (slm.height_px - 1)};
}

/// Phase of a subaperture along row y, waves (paper eq. 4). The grating's phase is 0 at the pupil's
/// centre; the vortex angle is measured about the subaperture's centre.
void subaperture_row(const SlmGeometry& slm, const Subaperture& s, double diameter_px, int y,
                     std::span<double> waves) {
  const Vec2 pupil = pupil_centre(slm);
  const Vec2 centre = pupil + s.centre_px;
  const Columns columns = columns_in_circle(centre, diameter_px, y, slm.width_px);
  for (int x = columns.begin; x < columns.end; ++x) {
    const double turns = std::atan2(y - centre.y, x - centre.x) / (2.0 * std::numbers::pi);
    waves[x] =
        s.charge * turns + s.frequency_cpp.x * (x - pupil.x) + s.frequency_cpp.y * (y - pupil.y);
  }
}

/// Adds a mask to a subaperture's phase along row y.
void add_mask_row(const MaskConfig& mask, const SlmGeometry& slm, const Subaperture& s,
                  double diameter_px, int y, std::span<double> waves) {
  const Vec2 centre = pupil_centre(slm) + s.centre_px;
  const Columns columns = columns_in_circle(centre, diameter_px, y, slm.width_px);
  for (int x = columns.begin; x < columns.end; ++x) {
    waves[x] += mask_waves(mask, (2.0 / diameter_px) * Vec2{x - centre.x, y - centre.y});
  }
}

bool reaches(const Subaperture& s, const SlmGeometry& slm, double diameter_px, int y) {
  return std::abs(y - pupil_centre(slm).y - s.centre_px.y) <= 0.5 * diameter_px;
}

void sensor_row(const HologramConfig& config, const Lattice& lattice, int y,
                std::span<double> waves) {
  for (std::size_t i = 0; i < lattice.subapertures.size(); ++i) {
    const Subaperture& s = lattice.subapertures[i];
    if (!reaches(s, config.slm, lattice.diameter_px, y)) continue;
    subaperture_row(config.slm, s, lattice.diameter_px, y, waves);
    for (const MaskConfig& mask : config.sensor.masks) {
      if (!is_masked(mask, int(i))) continue;
      add_mask_row(mask, config.slm, s, lattice.diameter_px, y, waves);
    }
  }
}

/// Base grating along row y, only inside the pupil. Outside the pupil no correction is known, so
/// light from there stays in the zeroth order.
void grating_row(const HologramConfig& config, int y, std::span<double> waves) {
  const Vec2 pupil = pupil_centre(config.slm);
  const Columns columns =
      columns_in_circle(pupil, config.sensor.pupil_diameter_px, y, config.slm.width_px);
  const double fx = config.sensor.grooves[0] / config.slm.width_px;
  const double fy = config.sensor.grooves[1] / config.slm.height_px;
  for (int x = columns.begin; x < columns.end; ++x) {
    waves[x] = fx * (x - pupil.x) + fy * (y - pupil.y);
  }
}

/// Adds the flatness map to `waves` and rounds the sum once to 16-bit phase (phase16).
void add_flatness_and_wrap(const HologramConfig& config, int y, std::span<double> waves,
                           std::uint16_t* phase) {
  const float* flatness = config.flatness_waves ? config.flatness_waves->row(y) : nullptr;
  for (std::size_t x = 0; x < waves.size(); ++x) {
    phase[x] = phase16(waves[x] + (flatness ? static_cast<double>(flatness[x]) : 0.0));
  }
}

constexpr int kIdentifyCols = 30;
constexpr std::array<std::string_view, 18> kIdentify{"##############################",  //
                                                     "#                            #",  //
                                                     "#  ###  #   # #   #  ####    #",  //
                                                     "# #   # #   # #   # #        #",  //
                                                     "# #   # #   # #   # #        #",  //
                                                     "# #   # #   # # # #  ###     #",  //
                                                     "# #   #  # #  # # #     #    #",  //
                                                     "# #   #  # #  ## ##     #    #",  //
                                                     "#  ###    #   #   # ####     #",  //
                                                     "#                            #",  //
                                                     "#   #              #         #",  //
                                                     "#   #   # #         #  #   # #",  //
                                                     "# # # # # #  #########  # #  #",  //
                                                     "#  ###   #          #    #   #",  //
                                                     "#   #    #         #    # #  #",  //
                                                     "#       #              #   # #",  //
                                                     "#                            #",  //
                                                     "##############################"};

/// Identify image: shows a person which screen is the SLM, and its orientation. Draws a frame,
/// "OVWS" upright and arrows towards +x and +y, white on black. Does not apply the LUT.
void draw_identify_image(Image<std::uint8_t>& grey) {
  const int rows = static_cast<int>(kIdentify.size());
  for (int y = 0; y < grey.height; ++y) {
    const std::string_view line = kIdentify[std::int64_t{y} * rows / grey.height];
    for (int x = 0; x < grey.width; ++x) {
      grey.at(x, y) = line[std::int64_t{x} * kIdentifyCols / grey.width] == '#' ? 255 : 0;
    }
  }
}

Result<void> check_flatness(const HologramConfig& config) {
  if (!config.flatness_waves) return {};
  const Image<float>& map = *config.flatness_waves;
  if (map.width != config.slm.width_px || map.height != config.slm.height_px) {
    return fail(Errc::invalid, "slm.flatness",
                "the flatness map has " + std::to_string(map.width) + " x " +
                    std::to_string(map.height) + " pixels, but the SLM has " +
                    std::to_string(config.slm.width_px) + " x " +
                    std::to_string(config.slm.height_px) + ": the sizes must be equal");
  }
  if (!std::all_of(map.pixels.begin(), map.pixels.end(),
                   [](float v) { return std::isfinite(v); })) {
    return fail(Errc::invalid, "slm.flatness",
                "the flatness map contains NaN or infinity: give a finite phase for every pixel");
  }
  return {};
}

Result<void> check_modes(std::span<const Mode> modes) {
  for (const Mode& mode : modes) {
    if (mode.j < 0 || mode.j > kMaxZernikeIndex) {
      return fail(Errc::invalid, "modes",
                  "mode j = " + std::to_string(mode.j) + " is not supported: use j = 0 to " +
                      std::to_string(kMaxZernikeIndex));
    }
    if (!(std::abs(mode.waves) <= kMaxWaves)) {
      return fail(Errc::invalid, "modes",
                  "the coefficient of mode j = " + std::to_string(mode.j) +
                      " must be a number from -1e6 to 1e6 waves");
    }
  }
  return {};
}

double max_abs_slope(std::span<const double> slopes, double carrier_cpp) {
  double found = 0.0;
  for (const double slope : slopes) found = std::max(found, std::abs(slope + carrier_cpp));
  return found;
}

/// Upper bound of the slopes of `modes` in the pupil, cycles per SLM pixel: the gradient of a
/// polynomial of degree n that is at most 1 in the unit circle is at most n^2 there (Sarantopoulos,
/// Proc. Am. Math. Soc. 113, 1991).
double steepest(std::span<const Mode> modes, double pupil_radius_px) {
  double bound = 0.0;
  for (const Mode& mode : modes) {
    const double degree = zernike_index(mode.j).n;
    bound += std::abs(mode.waves) * zernike_rms_factor(mode.j) * degree * degree;
  }
  return bound / pupil_radius_px;
}

/// Maximum |d phase / dx| and |d phase / dy| over the subaperture's pixels, cycles per SLM pixel.
/// Includes grating and modes. Excludes the vortex's slope, charge / (2 pi r): it is singular at
/// the vortex's centre, and the Nyquist limit does not matter there.
Vec2 max_slope(const WavefrontRows& modes, const Subaperture& s, const Lattice& lattice,
               const SlmGeometry& slm) {
  const Vec2 centre = pupil_centre(slm) + s.centre_px;
  const double radius = 0.5 * lattice.diameter_px;
  std::vector<double> slopes;
  Vec2 found;
  const int last = std::min(slm.height_px - 1, static_cast<int>(std::floor(centre.y + radius)));
  for (int y = std::max(0, static_cast<int>(std::ceil(centre.y - radius))); y <= last; ++y) {
    const Columns columns = columns_in_circle(centre, lattice.diameter_px, y, slm.width_px);
    if (columns.begin >= columns.end) continue;
    slopes.resize(columns.end - columns.begin);
    modes.slopes_x(y, columns.begin, slopes);
    found.x = std::max(found.x, max_abs_slope(slopes, s.frequency_cpp.x));
    modes.slopes_y(y, columns.begin, slopes);
    found.y = std::max(found.y, max_abs_slope(slopes, s.frequency_cpp.y));
  }
  return found;
}

}  // namespace

std::vector<Mode> shown_modes(HologramKind kind, std::vector<Mode> aberration,
                              std::span<const Mode> correction) {
  std::vector<Mode> modes;
  if (kind != HologramKind::grating) modes = std::move(aberration);
  for (const Mode& correcting : correction) {
    add_mode(modes, {correcting.j, -correcting.waves});
  }
  return modes;
}

PhaseLut linear_lut() {
  PhaseLut lut{};
  for (std::size_t k = 0; k < lut.size(); ++k) lut[k] = static_cast<std::uint8_t>(k);
  return lut;
}

Result<HologramRenderer> HologramRenderer::make(const HologramConfig& config) {
  auto lattice = make_lattice(config.sensor, config.slm);
  if (!lattice) return fail(lattice.error());
  if (auto ok = check_flatness(config); !ok) return fail(ok.error());
  if (config.dmd) {
    if (auto ok = check_dmd(*config.dmd, *lattice); !ok) return fail(ok.error());
  }
  HologramRenderer renderer;
  renderer.config_ = config;
  renderer.lattice_ = std::move(*lattice);
  renderer.base_phase_.resize(std::size_t(config.slm.width_px) * config.slm.height_px);
  std::vector<double> waves(config.slm.width_px);
  for (int y = 0; y < config.slm.height_px; ++y) {
    renderer.pattern_row(HologramKind::sensor, y, waves,
                         &renderer.base_phase_[std::size_t(y) * config.slm.width_px]);
  }
  const std::vector<std::uint16_t> no_modes(config.slm.width_px, 0);
  std::vector<std::uint16_t> limits(config.slm.width_px);
  renderer.base_grey_ = {config.slm.width_px, config.slm.height_px};
  for (int y = 0; y < config.slm.height_px; ++y) {
    if (config.dmd) {
      sensor_limits_row(*config.dmd, renderer.lattice_, config.slm, y, limits);
      renderer.limits_.insert(renderer.limits_.end(), limits.begin(), limits.end());
    }
    renderer.levels(&renderer.base_phase_[std::size_t(y) * config.slm.width_px], no_modes.data(),
                    limits.data(), config.slm.width_px, renderer.base_grey_.row(y));
  }
  return renderer;
}

void HologramRenderer::pattern_row(HologramKind kind, int y, std::span<double> waves,
                                   std::uint16_t* phase) const {
  std::fill(waves.begin(), waves.end(), 0.0);
  const bool drawn = config_.sensor.lenslets.empty();
  if (kind == HologramKind::sensor && drawn) sensor_row(config_, lattice_, y, waves);
  if (kind == HologramKind::grating) grating_row(config_, y, waves);
  add_flatness_and_wrap(config_, y, waves, phase);
}

void HologramRenderer::limits_row(HologramKind kind, int y,
                                  std::vector<std::uint16_t>& limits) const {
  if (!config_.dmd) return;
  Columns lit{0, config_.slm.width_px};
  if (kind == HologramKind::grating) {
    lit = columns_in_circle(pupil_centre(config_.slm), config_.sensor.pupil_diameter_px, y,
                            config_.slm.width_px);
  }
  std::fill(limits.begin(), limits.end(), std::uint16_t(0));
  std::fill(limits.begin() + lit.begin, limits.begin() + lit.end, mirror_limit(0.5));
}

void HologramRenderer::levels(const std::uint16_t* base, const std::uint16_t* added,
                              const std::uint16_t* limits, int count, std::uint8_t* grey) const {
  if (config_.dmd) return switch_mirrors(base, added, limits, count, grey);
  look_up_greys(base, added, config_.lut.data(), count, grey);
}

void HologramRenderer::render(HologramKind kind, std::span<const Mode> modes,
                              Image<std::uint8_t>& grey) const {
  const int width = sized(grey).width;
  if (kind == HologramKind::identify) return draw_identify_image(grey);
  if (kind != HologramKind::sensor && kind != HologramKind::grating) modes = {};
  const Vec2 centre = pupil_centre(config_.slm);
  const double diameter_px = config_.sensor.pupil_diameter_px;
  const WavefrontRows added(modes, centre, diameter_px);
  WavefrontRows::Polynomial along_row;
  const int right = int(std::ceil(centre.x)), left = int(std::floor(centre.x));
  std::vector<double> from_centre(width / 2 + 1 + kSparePixels);  // x, pupil radii
  for (std::size_t k = 0; k < from_centre.size(); ++k) {
    from_centre[k] = (right + double(k) - centre.x) / added.radius_px();
  }
  std::vector<double> waves(width);
  std::vector<std::uint16_t> pattern(width);
  const std::vector<std::uint16_t> none(width, 0);
  std::vector<std::uint16_t> with_spare(width + 2 * kSparePixels);
  std::uint16_t* const phase = with_spare.data() + kSparePixels;
  std::vector<std::uint8_t> without_modes(width);
  std::vector<std::uint16_t> row_limits(width);
  for (int y = 0; y < grey.height; ++y) {
    const std::uint16_t* base = &base_phase_[std::size_t(y) * width];
    const std::uint8_t* plain = base_grey_.row(y);
    const std::uint16_t* limits = limits_.data() + (config_.dmd ? std::size_t(y) * width : 0);
    if (kind != HologramKind::sensor) {
      pattern_row(kind, y, waves, pattern.data());
      base = pattern.data();
      limits_row(kind, y, row_limits);
      limits = row_limits.data();
      levels(base, none.data(), limits, width, without_modes.data());
      plain = without_modes.data();
    }
    Columns shown;
    if (!modes.empty()) shown = columns_in_circle(centre, diameter_px, y, width);
    added.along_row(y, along_row);
    mirrored_phases(along_row, from_centre.data(),
                    std::max(shown.end - right, left + 1 - shown.begin), phase + right,
                    phase + left);
    std::uint8_t* out = grey.row(y);
    std::copy(plain, plain + shown.begin, out);
    levels(base + shown.begin, phase + shown.begin, limits + (config_.dmd ? shown.begin : 0),
           shown.end - shown.begin, out + shown.begin);
    std::copy(plain + shown.end, plain + width, out + shown.end);
  }
}

Image<std::uint8_t>& HologramRenderer::sized(Image<std::uint8_t>& grey) const {
  grey.width = config_.slm.width_px;
  grey.height = config_.slm.height_px;
  grey.pixels.resize(std::size_t(grey.width) * grey.height);
  return grey;
}

void HologramRenderer::render_probe(const Probe& probe, Image<std::uint8_t>& grey) const {
  const int width = sized(grey).width;
  std::vector<double> waves(width);
  std::vector<std::uint16_t> phase(width);
  const std::vector<std::uint16_t> none(width, 0);
  const Subaperture lone{probe.centre_px, probe.frequency_cpp, probe.charge};
  const double diameter_px = probe.diameter_px > 0.0 ? probe.diameter_px : lattice_.diameter_px;
  const WavefrontRows added(probe.modes, pupil_centre(config_.slm),
                            config_.sensor.pupil_diameter_px);
  std::vector<double> added_waves(width);
  std::vector<std::uint16_t> limits(width);
  for (int y = 0; y < grey.height; ++y) {
    std::fill(waves.begin(), waves.end(), 0.0);
    subaperture_row(config_.slm, lone, diameter_px, y, waves);
    const Columns lit =
        columns_in_circle(pupil_centre(config_.slm) + probe.centre_px, diameter_px, y, width);
    const auto part = std::span(added_waves).first(std::size_t(std::max(0, lit.end - lit.begin)));
    added.waves(y, lit.begin, part);
    for (std::size_t k = 0; k < part.size(); ++k) waves[std::size_t(lit.begin) + k] += part[k];
    add_flatness_and_wrap(config_, y, waves, phase.data());
    if (config_.dmd) {
      std::fill(limits.begin(), limits.end(), std::uint16_t(0));
      std::fill(limits.begin() + lit.begin, limits.begin() + std::max(lit.begin, lit.end),
                mirror_limit(0.5));
    }
    levels(phase.data(), none.data(), limits.data(), width, grey.row(y));
  }
}

void HologramRenderer::render_picture(const Picture& picture, Image<std::uint8_t>& grey) const {
  const int width = sized(grey).width;
  HologramConfig config = config_;
  if (!picture.flatness) config.flatness_waves.reset();
  const PhaseLut lut = picture.lut ? config_.lut : linear_lut();
  const Vec2 centre = pupil_centre(config_.slm);
  const double diameter_px = config_.sensor.pupil_diameter_px;
  const WavefrontRows added(picture.modes, centre, diameter_px);
  std::vector<double> waves(width), added_waves(width);
  std::vector<std::uint16_t> phase(width);
  const std::vector<std::uint16_t> none(width, 0);
  std::vector<std::uint16_t> limits(width);
  limits_row(HologramKind::test, 0, limits);
  for (int y = 0; y < grey.height; ++y) {
    const Columns pupil = columns_in_circle(centre, diameter_px, y, width);
    const float* from = picture.waves.row(y);
    for (int x = 0; x < width; ++x) {
      const bool shown = !picture.inside_pupil || (x >= pupil.begin && x < pupil.end);
      waves[x] = shown ? double(from[x]) : 0.0;
    }
    const auto part =
        std::span(added_waves).first(std::size_t(std::max(0, pupil.end - pupil.begin)));
    added.waves(y, pupil.begin, part);
    for (std::size_t k = 0; k < part.size(); ++k) waves[std::size_t(pupil.begin) + k] += part[k];
    add_flatness_and_wrap(config, y, waves, phase.data());
    if (config_.dmd && !picture.lut) {  // grey levels of 128 and more are on
      std::transform(phase.begin(), phase.end(), grey.row(y),
                     [](std::uint16_t one) { return one >> 15 ? 255 : 0; });
    } else if (config_.dmd) {
      switch_mirrors(phase.data(), none.data(), limits.data(), width, grey.row(y));
    } else {
      look_up_greys(phase.data(), none.data(), lut.data(), width, grey.row(y));
    }
  }
}

Result<void> HologramRenderer::check_sampling(std::span<const Mode> modes) const {
  if (auto ok = check_modes(modes); !ok || !config_.sensor.lenslets.empty()) return ok;
  const double pupil_radius_px = 0.5 * config_.sensor.pupil_diameter_px;
  const double bound = steepest(modes, pupil_radius_px);
  const WavefrontRows added(modes, pupil_centre(config_.slm), config_.sensor.pupil_diameter_px);
  for (std::size_t i = 0; i < lattice_.subapertures.size(); ++i) {
    const Subaperture& s = lattice_.subapertures[i];
    const double grating = std::max(std::abs(s.frequency_cpp.x), std::abs(s.frequency_cpp.y));
    const double reach_px = std::hypot(s.centre_px.x, s.centre_px.y) + 0.5 * lattice_.diameter_px;
    if (reach_px <= pupil_radius_px && grating + bound <= kNyquistCpp) continue;  // usual, and fast
    const Vec2 found = max_slope(added, s, lattice_, config_.slm);
    if (found.x <= kNyquistCpp && found.y <= kNyquistCpp) continue;
    return fail(Errc::invalid, "modes",
                "too steep for the SLM: subaperture " + std::to_string(i) + " needs " +
                    with_decimals(found.x, 6) + " (x) and " + with_decimals(found.y, 6) +
                    " (y) cycles per SLM pixel; the limit is 0.5. Its grating alone needs " +
                    with_decimals(s.frequency_cpp.x, 6) + " and " +
                    with_decimals(s.frequency_cpp.y, 6) + ": reduce the aberration or the grating");
  }
  return {};
}

}  // namespace ovws
