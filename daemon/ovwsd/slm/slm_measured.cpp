#include "daemon/ovwsd/slm/slm_measured.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <span>

#include "core/optics/flatness.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/json_text.hpp"
#include "proto/limits.hpp"
#include "proto/reader.hpp"
#include "proto/tables/origin.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr double kMaxRad = 1000.0;

/// Reads the fields that a measured LUT and a measured flatness have in common.
template <class T>
void read_common(ObjectReader& r, T& measured) {
  for (const char* key : {"t_taken_ns", "frames", "origin"}) r.require(key);
  const json* const taken = r.raw("t_taken_ns");
  if (taken != nullptr && taken->is_number_integer()) {
    measured.t_taken_ns = taken->template get<std::int64_t>();
  } else {
    r.fault("t_taken_ns", "must be a whole number");
  }
  r.integer("frames", measured.frames, 1, limits::kReferenceFrames.max);
  const json* const origin = r.raw("origin");
  if (origin != nullptr && origin->is_object()) measured.origin = *origin;
}

/// Compares a section of a measurement's origin with the present values `parts`. Describes the
/// first value that differs; empty: all are equal.
std::string difference(const json& origin, const char* section,
                       std::initializer_list<std::pair<const char*, json>> parts) {
  const json then = origin.value(section, json::object());
  for (const auto& [key, now] : parts) {
    const json before = then.value(key, json());
    if (before == now) continue;
    return fmt::format("{}.{} was {}, and is {}", section, key, json_text(before), json_text(now));
  }
  return {};
}

/// Why a measurement with this `origin` does not fit the configured SLM; empty: it fits.
std::string slm_mismatch(const json& origin, const Config& config) {
  const SlmGeometry& now = config.slm.geometry;
  const std::string other =
      difference(origin, "slm",
                 {{"width", now.width_px}, {"height", now.height_px}, {"pitch_um", now.pitch_um}});
  if (!other.empty()) return "it belongs to another SLM: " + other;
  return difference(origin, "optics", {{"wavelength_nm", config.optics.wavelength_nm}});
}

}  // namespace

json LutKind::content(const MeasuredLut& lut) const {
  const PhaseResponse& r = lut.response;
  return {{"t_taken_ns", lut.t_taken_ns},
          {"frames", lut.frames},
          {"levels", r.levels},
          {"phase_rad", r.phase_rad},
          {"standard_error_rad", r.standard_error_rad},
          {"noise_rad", r.noise_rad},
          {"residual_rad", r.residual_rad},
          {"origin", lut.origin}};
}

Result<MeasuredLut> LutKind::read(const json& content) const {
  MeasuredLut lut;
  std::vector<double> phase, error;
  ObjectReader r(content, "lut");
  read_common(r, lut);
  for (const char* key : {"levels", "phase_rad", "standard_error_rad"}) r.require(key);
  r.integer("levels", lut.response.levels, 2, 256);
  r.numbers("phase_rad", phase, 256, 256, -kMaxRad, kMaxRad);
  r.numbers("standard_error_rad", error, 256, 256, 0.0, kMaxRad);
  r.number("noise_rad", lut.response.noise_rad, 0.0, kMaxRad);
  r.number("residual_rad", lut.response.residual_rad, 0.0, kMaxRad);
  if (auto read = r.finish(); !read) return fail(read.error());
  if (!std::is_sorted(phase.begin(), phase.end()) &&
      !std::is_sorted(phase.rbegin(), phase.rend())) {
    return fail(Errc::invalid, "lut.phase_rad", "is not monotonic");
  }
  std::copy(phase.begin(), phase.end(), lut.response.phase_rad.begin());
  std::copy(error.begin(), error.end(), lut.response.standard_error_rad.begin());
  lut.table = linearising_lut(lut.response.phase_rad);
  return lut;
}

std::string LutKind::obstacle(const MeasuredLut& lut) const {
  return slm_mismatch(lut.origin, config);
}

json FlatnessKind::content(const MeasuredFlatness& flatness) const {
  json modes = json::array();
  for (const Mode& mode : flatness.modes) modes.push_back({{"j", mode.j}, {"waves", mode.waves}});
  json content{{"t_taken_ns", flatness.t_taken_ns},
               {"frames", flatness.frames},
               {"iterations", flatness.iterations},
               {"pupil_diameter_px", flatness.pupil_diameter_px},
               {"modes", std::move(modes)},
               {"standard_error_waves", flatness.standard_error_waves},
               {"residual_rms_waves", flatness.residual_rms_waves},
               {"configured_sha256", flatness.configured_sha256},
               {"origin", flatness.origin}};
  if (flatness.fine.pixels.empty()) return content;
  content["fine"] = {{"cells", flatness.fine.width},
                     {"base64", base64_of(std::span<const float>(flatness.fine.pixels))}};
  return content;
}

namespace {

/// Reads the map of what the modes leave, if there is one.
Result<void> read_fine(const json* given, Image<float>& fine) {
  if (given == nullptr) return {};
  const auto wrong = fail(Errc::invalid, "flatness.fine", "is not a map of float32 in base64");
  if (!given->is_object() || !given->contains("cells") || !given->contains("base64")) return wrong;
  const json &cells = given->at("cells"), &base64 = given->at("base64");
  if (!cells.is_number_integer() || !base64.is_string()) return wrong;
  const int side = cells.get<int>();
  if (side < limits::kMapCells.min || side > limits::kMapCells.max) return wrong;
  auto values =
      floats_of(base64.get_ref<const std::string&>(), std::size_t(side) * std::size_t(side));
  if (!values || std::ranges::any_of(*values, [](float waves) {
        return std::abs(waves) > float(limits::kModeWaves.max);
      })) {
    return wrong;
  }
  fine = Image<float>(side, side);
  fine.pixels = std::move(*values);
  return {};
}

}  // namespace

Result<MeasuredFlatness> FlatnessKind::read(const json& content) const {
  MeasuredFlatness flatness;
  ObjectReader r(content, "flatness");
  read_common(r, flatness);
  for (const char* key :
       {"pupil_diameter_px", "modes", "standard_error_waves", "configured_sha256"}) {
    r.require(key);
  }
  r.integer("iterations", flatness.iterations, 1, 1000);
  r.number("pupil_diameter_px", flatness.pupil_diameter_px, limits::kPupilDiameterPx.min,
           limits::kPupilDiameterPx.max);
  r.objects("modes", kMaxZernikeIndex, [&](ObjectReader& one, std::size_t) {
    Mode mode;
    one.require("j");
    one.require("waves");
    one.integer("j", mode.j, 3, kMaxZernikeIndex);
    one.number("waves", mode.waves, limits::kModeWaves.min, limits::kModeWaves.max);
    flatness.modes.push_back(mode);
  });
  r.numbers("standard_error_waves", flatness.standard_error_waves, 0, kMaxZernikeIndex, 0.0, 1e6);
  r.number("residual_rms_waves", flatness.residual_rms_waves, 0.0, 1e6);
  if (const json* const sum = r.raw("configured_sha256")) flatness.configured_sha256 = *sum;
  if (auto fine = read_fine(r.raw("fine"), flatness.fine); !fine) return fail(fine.error());
  if (auto read = r.finish(); !read) return fail(read.error());
  if (flatness.modes.empty() || flatness.modes.size() != flatness.standard_error_waves.size()) {
    return fail(Errc::invalid, "flatness.modes",
                "must have as many entries as standard_error_waves");
  }
  return flatness;
}

/// Why a flatness cannot be used: another SLM, other optics, or another slm.flatness map than the
/// one that it was measured with.
std::string FlatnessKind::obstacle(const MeasuredFlatness& flatness) const {
  if (auto other = slm_mismatch(flatness.origin, config); !other.empty()) return other;
  if (flatness.configured_sha256 != configured_sha256) {
    return fmt::format("it was measured with another map in slm.flatness (SHA-256 {} then, {} now)",
                       json_text(flatness.configured_sha256), json_text(configured_sha256));
  }
  const OpticsConfig& now = config.optics;
  return difference(flatness.origin, "optics",
                    {{"focal_length_mm", now.focal_length_mm},
                     {"magnification", now.magnification},
                     {"camera_pitch_um", now.camera_pitch_um}});
}

nlohmann::json flatness_sha256(const HologramConfig& hologram) {
  if (!hologram.flatness_waves) return nullptr;
  return sha256_of(std::span<const float>(hologram.flatness_waves->pixels));
}

nlohmann::json slm_identity(const HologramConfig& hologram, bool has_lut) {
  SlmIdentity slm{hologram.slm, std::nullopt, std::nullopt};
  if (has_lut) slm.lut_sha256 = sha256_of(std::span<const std::uint8_t>(hologram.lut));
  if (const auto& dmd = hologram.dmd) {
    std::vector<double> facts{dmd->apodisation};
    facts.insert(facts.end(), dmd->amplitudes.begin(), dmd->amplitudes.end());
    slm.lut_sha256 = sha256_of(std::span<const double>(facts));
  }
  if (const auto sum = flatness_sha256(hologram); !sum.is_null()) slm.flatness_sha256 = sum;
  return to_json(slm);
}

std::shared_ptr<const ActiveSlm> active_slm(const Config& config, const HologramConfig& configured,
                                            std::shared_ptr<const MeasuredLut> lut,
                                            std::shared_ptr<const MeasuredFlatness> flatness) {
  auto slm = std::make_shared<ActiveSlm>();
  slm->hologram = configured;
  if (lut) slm->hologram.lut = lut->table.lut;
  if (flatness)
    slm->hologram.flatness_waves =
        flattened(configured, flatness->modes, flatness->fine, flatness->pupil_diameter_px);
  slm->identity = slm_identity(slm->hologram, lut || config.slm.lut);
  slm->lut = std::move(lut);
  slm->flatness = std::move(flatness);
  return slm;
}

}  // namespace ovws
